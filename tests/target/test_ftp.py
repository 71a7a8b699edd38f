# SPDX-License-Identifier: MIT
"""MAVLink FTP: both files arrive whole over a lossy link."""

from __future__ import annotations

import json
import random
import struct
import zlib
from dataclasses import dataclass, field

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.sea import Sea, named
from tests.target.stations import BOAT, GCS, Station

FILES: dict[str, bytes] = flotilla.metadata()
TERMINATE, RESET, LIST, OPEN, READ, CRC, BURST = 1, 2, 3, 4, 5, 14, 15
ACK, NAK = 128, 129
INVALID_DATA_SIZE, INVALID_SESSION, EOF, UNKNOWN_COMMAND, NOT_FOUND = 3, 4, 6, 7, 10
MOST = 239


@dataclass(frozen=True)
class Packet:
    seq: int
    session: int
    opcode: int
    size: int = 0
    asked: int = 0
    burst_complete: int = 0
    offset: int = 0
    data: bytes = b""

    @property
    def wire(self) -> list[int]:
        header = struct.pack(
            "<HBBBBBBI",
            self.seq % 65536,
            self.session,
            self.opcode,
            self.size,
            self.asked,
            self.burst_complete,
            0,
            self.offset,
        )
        return list((header + self.data).ljust(251, b"\0"))

    @staticmethod
    def read(payload: list[int]) -> Packet:
        raw = bytes(payload)
        seq, session, opcode, size, asked, complete, _, offset = struct.unpack(
            "<HBBBBBBI", raw[:12]
        )
        return Packet(seq, session, opcode, size, asked, complete, offset, raw[12 : 12 + size])


@dataclass
class Client:
    """A ground station with packet loss in both directions."""

    sea: Sea
    station: Station = field(default_factory=lambda: Station(GCS, 190))
    link: int = 0
    loss: float = 0.0
    seed: int = 0
    seq: int = 0
    session: int = 0

    def __post_init__(self) -> None:
        self.rng = random.Random(self.seed)

    def say(self, packet: Packet) -> None:
        if self.rng.random() < self.loss:
            return
        message = mavlink.MAVLink_file_transfer_protocol_message(0, BOAT, 1, packet.wire)
        self.sea.say(message, sender=self.station, link=self.link)

    def hear(self, seconds: float) -> list[Packet]:
        found = named(self.sea.run(seconds), "FILE_TRANSFER_PROTOCOL", self.link)
        mine = [m for m in found if m.target_system == self.station.system]
        assert all(m.target_component == self.station.component for m in mine)
        return [Packet.read(m.payload) for m in mine if self.rng.random() >= self.loss]

    def packet(self, opcode: int, size: int = 0, offset: int = 0, data: bytes = b"") -> Packet:
        return Packet(self.seq, self.session, opcode, size, 0, 0, offset, data)

    def ask(self, opcode: int, size: int = 0, offset: int = 0, data: bytes = b"") -> Packet:
        """Repeat a request until its own answer arrives."""
        request = self.packet(opcode, size or len(data), offset, data)
        for _ in range(60):
            self.say(request)
            for answer in self.hear(0.05):
                if answer.seq == (request.seq + 1) % 65536 and answer.asked == opcode:
                    self.seq = answer.seq + 1
                    assert answer.session == self.session
                    return answer
        raise AssertionError(f"no answer to {request}")

    def open(self, path: bytes) -> int:
        answer = self.ask(OPEN, data=path)
        assert answer.opcode == ACK and answer.size == 4, answer
        return int(struct.unpack("<I", answer.data)[0])

    def download_by_reads(self, path: bytes, size: int = MOST) -> bytes:
        total, content = self.open(path), b""
        while True:
            answer = self.ask(READ, size, len(content))
            if answer.opcode == NAK:
                assert answer.data[0] == EOF and len(content) == total
                break
            assert answer.offset == len(content) and 0 < answer.size <= size
            content += answer.data
        assert self.ask(TERMINATE).opcode == ACK
        return content

    def download_by_bursts(self, path: bytes, size: int = MOST) -> bytes:
        """Request bursts from the first missing byte until none is missing."""
        total = self.open(path)
        got: dict[int, bytes] = {}
        for _ in range(300):
            missing = 0
            while missing in got:
                missing += len(got[missing])
            if missing == total:
                break
            request = self.packet(BURST, size, missing)
            self.say(request)
            for answer in self.hear(0.3):
                if answer.asked == BURST and answer.opcode == ACK:
                    got[answer.offset] = answer.data
                    assert 1 <= (answer.seq - request.seq) % 65536 < 200
                    at_end = answer.offset + answer.size == total
                    assert bool(answer.burst_complete) == at_end
                    self.seq = answer.seq + 1
            self.seq += 1
        assert self.ask(BURST, size, total).data[:1] == bytes([EOF])
        assert self.ask(TERMINATE).opcode == ACK
        return b"".join(got[at] for at in sorted(got))


@pytest.fixture
def client(sea: Sea) -> Client:
    sea.settle()
    return Client(sea)


EACH_FILE = pytest.mark.parametrize("name", list(FILES))


@EACH_FILE
@pytest.mark.parametrize("how", ["reads", "bursts"])
@pytest.mark.parametrize("loss", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("form", [b"/%s", b"%s", b"%s\0", b"/%s\0"], ids=repr)
def test_a_file_comes_whole_over_a_link_that_loses(
    name: str, how: str, loss: float, form: bytes
) -> None:
    sea = Sea()
    sea.settle()
    client = Client(sea, loss=loss, seed=hash_of(name, how))
    download = getattr(client, f"download_by_{how}")
    assert download(form.replace(b"%s", name.encode())) == FILES[name]
    assert sea.state == "DISARMED"


def hash_of(*words: str) -> int:
    return zlib.crc32("".join(words).encode())


@pytest.mark.parametrize("size", [1, 80, 110, 239])
@pytest.mark.parametrize("how", ["reads", "bursts"])
def test_a_file_comes_whole_with_any_read_size(client: Client, size: int, how: str) -> None:
    path = b"/general.json"
    assert getattr(client, f"download_by_{how}")(path, size) == FILES["general.json"]


def test_the_boat_reports_where_its_files_are_and_their_checksums(sea: Sea) -> None:
    sea.settle()
    (told,) = sea.order(512, 397.0).named("COMPONENT_METADATA")
    assert told.uri == "mftp:///general.json"
    client = Client(sea)
    general = client.download_by_bursts(b"/general.json")
    assert told.file_crc == zlib.crc32(general, 0xFFFFFFFF) ^ 0xFFFFFFFF
    (entry,) = json.loads(general)["metadataTypes"]
    path = entry["uri"].removeprefix("mftp://").encode()
    content = client.download_by_bursts(path)
    assert entry["fileCrc"] == zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF
    answer = client.ask(CRC, data=path)
    assert answer.opcode == ACK and struct.unpack("<I", answer.data) == (entry["fileCrc"],)


@pytest.mark.parametrize("session", [0, 1, 7, 255])
def test_the_client_chooses_the_session_number(sea: Sea, session: int) -> None:
    sea.settle()
    client = Client(sea, session=session)
    assert client.download_by_reads(b"/general.json") == FILES["general.json"]


def test_two_clients_on_two_links_download_at_once() -> None:
    sea = Sea(links=2)
    sea.settle()
    one, two = Client(sea), Client(sea, station=Station(254, 190), link=1)
    sizes = [one.open(b"/parameters.json"), two.open(b"/general.json")]
    assert sizes == [len(FILES["parameters.json"]), len(FILES["general.json"])]
    assert one.ask(READ, 50, 100).data == FILES["parameters.json"][100:150]
    assert two.ask(READ, 50, 20).data == FILES["general.json"][20:70]


def test_sequence_numbers_that_start_again_are_not_taken_for_repetitions(client: Client) -> None:
    """MAVProxy starts at 0 for each operation."""
    client.open(b"/parameters.json")
    for offset in (0, 50, 700):
        client.seq = 0
        assert client.ask(READ, 20, offset).data == FILES["parameters.json"][offset : offset + 20]


def test_sequence_numbers_wrap(client: Client) -> None:
    client.seq = 65534
    assert client.download_by_bursts(b"/parameters.json") == FILES["parameters.json"]


@pytest.mark.parametrize(
    ("opcode", "data", "error"),
    [
        (OPEN, b"/nothing.json", NOT_FOUND),
        (OPEN, b"@PARAM/param.pck?withdefaults=1", NOT_FOUND),
        (OPEN, b"/../etc/passwd", NOT_FOUND),
        (OPEN, b"/", NOT_FOUND),
        (READ, b"", INVALID_SESSION),
        (BURST, b"", INVALID_SESSION),
        (16, b"/", UNKNOWN_COMMAND),
        (6, b"/general.json", UNKNOWN_COMMAND),
        (7, b"x", UNKNOWN_COMMAND),
        (8, b"/general.json", UNKNOWN_COMMAND),
        (12, b"/general.json", UNKNOWN_COMMAND),
        (255, b"", UNKNOWN_COMMAND),
        (CRC, b"/nothing.json", NOT_FOUND),
    ],
    ids=repr,
)
def test_a_request_that_the_boat_cannot_do_is_refused_at_once(
    client: Client, opcode: int, data: bytes, error: int
) -> None:
    answer = client.ask(opcode, data=data)
    assert (answer.opcode, answer.data) == (NAK, bytes([error]))


@pytest.mark.parametrize("opcode", [ACK, NAK])
def test_an_answer_is_not_answered(client: Client, opcode: int) -> None:
    client.say(client.packet(opcode))
    assert not client.hear(0.5)


def test_a_read_beyond_the_end_of_a_file_is_answered_with_eof(client: Client) -> None:
    size = client.open(b"/general.json")
    for offset in (size, size + 1, 2**32 - 1):
        for opcode in (READ, BURST):
            answer = client.ask(opcode, MOST, offset)
            assert (answer.opcode, answer.data) == (NAK, bytes([EOF]))


def test_a_size_beyond_the_packet_is_refused(client: Client) -> None:
    client.open(b"/general.json")
    answer = client.ask(READ, 240)
    assert (answer.opcode, answer.data) == (NAK, bytes([INVALID_DATA_SIZE]))


def test_the_folder_lists_both_files(client: Client) -> None:
    answer = client.ask(LIST, data=b"/")
    entries = [e for e in answer.data.split(b"\0") if e]
    assert entries == [b"F%s\t%d" % (name.encode(), len(FILES[name])) for name in FILES]
    answer = client.ask(LIST, offset=len(entries), data=b"/")
    assert (answer.opcode, answer.data) == (NAK, bytes([EOF]))


def test_an_ended_session_is_invalid(client: Client) -> None:
    for end in (TERMINATE, RESET):
        client.open(b"/general.json")
        assert client.ask(end).opcode == ACK
        assert client.ask(READ, 10).data == bytes([INVALID_SESSION])
        assert client.ask(end).opcode == ACK


def test_a_download_goes_on_while_the_boat_sails(sea: Sea) -> None:
    sea.enter_formation()
    client = Client(sea, loss=0.1, seed=4)
    sea.ticks.clear()
    assert client.download_by_bursts(b"/parameters.json") == FILES["parameters.json"]
    assert sea.state == "FORMATION"
    seconds = len(sea.ticks) * sea.period_us * 1e-6
    assert len(named(sea.ticks, "ATTITUDE")) >= 9.5 * seconds - 1


@pytest.mark.parametrize("seed", range(4))
def test_random_requests_do_no_harm(seed: int) -> None:
    rng = random.Random(seed)
    sea = Sea()
    sea.settle()
    for _ in range(2000):
        payload = list(rng.randbytes(251))
        payload[3] = rng.choice([*range(18), 255])
        sea.say(mavlink.MAVLink_file_transfer_protocol_message(0, BOAT, rng.randrange(2), payload))
        sea.tick_only()
    sea.run(0.5)
    assert Client(sea).download_by_bursts(b"/general.json") == FILES["general.json"]
