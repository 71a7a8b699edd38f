# SPDX-License-Identifier: MIT
"""MAVLink links of every kind, seen from the other end."""

import os
import socket
import threading
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path

import flotilla
import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from sil.live.free_port import free_port
from tests.linux.process import LOOPBACK, PATIENT, RealSea, Serial, Udp, broadcast_listener, now_us
from tests.target.stations import BOAT, GCS, Station, command_long, decode
from tests.turns import some

RATE_BPS = 800


def test_udpin_answers_every_peer_it_has_heard_and_no_other(
    sea: RealSea, opened: ExitStack
) -> None:
    port = free_port()
    unheard = Udp(port)
    opened.callback(unheard.close)
    sea.connect(Udp(port), Udp(port))
    sea.start()
    sea.until(sea.ready)
    sea.enter_formation()
    for link in range(2):
        assert sea.named("HEARTBEAT", link) and sea.named("ATTITUDE", link)
    assert sea.acks(0) == sea.acks(1) != []
    assert unheard.receive() == []


def test_udpin_forgets_a_silent_peer_only_when_it_needs_the_place(
    sea: RealSea, opened: ExitStack
) -> None:
    port = free_port()
    sea.connect(Udp(port))
    sea.start()
    sea.until(sea.ready)
    peers = [Udp(port) for _ in range(8)]

    def answered() -> list[bool]:
        for peer in peers:
            peer.receive()
        beats = len(sea.named("HEARTBEAT"))
        sea.until(lambda: len(sea.named("HEARTBEAT")) > beats + 1)
        return [bool(peer.receive()) for peer in peers]

    def greet(peer: Udp) -> None:
        heard = len(sea.acks())
        peer.send(sea.gcs.pack(command_long(0)))
        sea.until(lambda: len(sea.acks()) > heard)  # one after the other

    for peer in peers:
        opened.callback(peer.close)
        greet(peer)
    assert answered() == [True] * 7 + [False]  # eight with the one that keeps talking
    sea.run(3.0)
    greet(peers[-1])
    assert answered() == [False] + [True] * 7


@pytest.mark.parametrize("garbage", [True, False])
def test_nine_strangers_do_not_reduce_an_operators_telemetry(
    sea: RealSea, opened: ExitStack, garbage: bool
) -> None:
    """`garbage`: each sends one byte 20 times a second; else HEARTBEATs of other boats."""
    port = free_port()
    operator = Udp(port)
    sea.connect(Udp(), operator)
    sea.start()
    sea.until(sea.ready)

    def flow() -> float:
        sea.run(1.0)
        before, began_us = sea.bytes_heard[1], now_us()
        sea.run(4.0)
        return (sea.bytes_heard[1] - before) / (1e-6 * (now_us() - began_us))

    calm = flow()
    strangers = [Udp(port) for _ in range(9)]
    stop = threading.Event()

    def shout() -> None:
        while not stop.wait(0.05):
            for number, stranger in enumerate(strangers):
                beat = mavlink.MAVLink_heartbeat_message(11, 0, 0, 0, 4, 3)
                stranger.send(b"x" if garbage else Station(100 + number, 1).pack(beat))

    thread = threading.Thread(target=shout)
    thread.start()
    opened.callback(lambda: [stranger.close() for stranger in strangers])
    opened.callback(thread.join)
    opened.callback(stop.set)
    flooded = flow()
    print(f"operator hears {calm:.0f} B/s, beside nine strangers {flooded:.0f} B/s")
    assert flooded > 0.8 * calm
    if garbage:
        assert not any(stranger.receive() for stranger in strangers)


def test_a_boat_sails_by_a_serial_port_alone(sea: RealSea, tmp_path: Path) -> None:
    sea.connect(Serial(tmp_path / "ttyS0"))
    sea.start()
    sea.enter_formation()
    assert not any(m.get_type() == "BAD_DATA" for m in sea.messages[0])


def test_links_of_every_kind_work_at_once(sea: RealSea, tmp_path: Path) -> None:
    sea.connect(Udp(free_port()), Udp(), Serial(tmp_path / "ttyS0"), broadcast_listener())
    sea.start()
    sea.enter_formation()  # the operator answers where the broadcast came from
    for link in range(4):
        assert sea.named("HEARTBEAT", link) and sea.named("ATTITUDE", link)
        assert sea.named("STATUSTEXT", link)
    assert sea.acks(3) and not any(sea.acks(link) for link in range(3))


def addresses_of(pid: int) -> set[str]:
    """The local addresses to which the process's UDP sockets are bound: proc(5)."""
    inodes = set()
    for fd in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(FileNotFoundError):
            inodes.add(os.readlink(fd).removeprefix("socket:[").removesuffix("]"))
    lines = [line.split() for line in Path(f"/proc/{pid}/net/udp").read_text().splitlines()]
    bound = [fields[1].partition(":")[0] for fields in lines[1:] if fields[9] in inodes]
    return {socket.inet_ntoa(bytes.fromhex(address)[::-1]) for address in bound}


@pytest.mark.parametrize(
    ("host", "bound"), [("", LOOPBACK), ("127.0.0.2:", "127.0.0.2"), ("0.0.0.0:", "0.0.0.0")]
)
def test_a_boat_binds_only_the_addresses_of_its_configuration(
    sea: RealSea, host: str, bound: str
) -> None:
    sea.connect(Udp(free_port()), Udp(), broadcast_listener())
    sea.start(f"--mavlink=udpin:{host}{free_port()}")
    sea.until(lambda: sea.named("HEARTBEAT", 1))
    group = f"239.65.82.{sea.bus}"
    assert addresses_of(sea.process.pid) == {LOOPBACK, bound, group}


def test_udpout_receives_only_from_its_peer(sea: RealSea, opened: ExitStack) -> None:
    stranger = Udp()
    opened.callback(stranger.close)
    sea.start()
    sea.until(sea.ready)
    end = sea.ends[0]
    assert isinstance(end, Udp)
    stranger.peer = end.peer
    for _ in range(20):
        stranger.send(sea.gcs.pack(command_long(0)))
    sea.say(command_long(1))
    sea.until(sea.acks)
    assert {command for command, _ in sea.acks()} == {1}


def test_no_datagram_is_longer_than_every_client_reads(sea: RealSea, opened: ExitStack) -> None:
    """gomavlib reads 512 bytes of a datagram; all parameters at once make ticks of 1400."""
    client = Udp()
    opened.callback(client.close)
    sea.start(f"--mavlink={client.option}")
    heard: list[bytes] = []

    def told() -> int:
        heard.extend(client.receive())
        return len([m for m in decode(heard) if m.get_type() == "PARAM_VALUE"])

    sea.until(lambda: told() or heard)
    client.send(sea.gcs.pack(mavlink.MAVLink_param_request_list_message(BOAT, 1)))
    sea.until(lambda: told() >= len(flotilla.parameter_list()))
    assert max(map(len, heard)) <= 500
    assert max(map(len, heard)) > 300  # several messages in one
    assert not [m for m in decode(heard) if m.get_type() == "BAD_DATA"]


def test_pymavlinks_own_connection_arms_the_boat_and_names_its_mode(
    sea: RealSea, opened: ExitStack
) -> None:
    port = free_port()
    station = mavutil.mavlink_connection(f"udpin:{LOOPBACK}:{port}", source_system=GCS)
    opened.callback(station.close)
    sea.start(f"--mavlink=udpout:{LOOPBACK}:{port}")
    sea.until(lambda: station.recv_match(type="HEARTBEAT"))
    assert (station.target_system, station.flightmode) == (BOAT, "HOLD")
    sea.until(lambda: station.recv_match(type="ATTITUDE"))  # its unit is heard

    def order(mode: str) -> None:
        station.arducopter_arm()
        station.set_mode(mode)

    def told(mode: str) -> bool:
        while station.recv_match() is not None:
            pass
        return bool(station.motors_armed()) and station.flightmode == mode

    for mode, state in (("FOLLOW", "FORMATION"), ("HOLD", "HOLD")):
        sea.repeat(partial(order, mode), partial(told, mode))
        sea.until(partial(lambda state: sea.state == state, state))


def test_telemetry_keeps_to_the_rate_of_a_slow_radio(sea: RealSea) -> None:
    sea.connect(Udp(), Udp())
    sea.ends[1].option += f",rate={RATE_BPS}"
    sea.start(param=PATIENT | {"SR_STATE": 50})
    sea.until(lambda: sea.named("ATTITUDE", 1))
    before, began_us = list(sea.bytes_heard), now_us()
    sea.run(2.0)
    seconds = 1e-6 * (now_us() - began_us)
    fast, slow = (now - then for now, then in zip(sea.bytes_heard, before, strict=True))
    saved_up = RATE_BPS / 2
    assert 0.5 * RATE_BPS * seconds < slow < 1.2 * RATE_BPS * seconds + saved_up
    assert fast > 2000 * seconds
    assert len(sea.named("HEARTBEAT", 1)) > 1


class Line(Serial):
    """A serial line with the throughput of its baud rate."""

    def __init__(self, device: Path, baud: int) -> None:
        super().__init__(device, baud)
        self._bytes_per_us = baud / 10 * 1e-6
        self._read_us = now_us()

    def receive(self) -> list[bytes]:
        room = int((now_us() - self._read_us) * self._bytes_per_us)
        if room == 0:
            return []
        self._read_us = now_us()
        with suppress(BlockingIOError):
            return [os.read(self._master, room)]
        return []


def test_a_slow_serial_line_brings_no_old_attitudes(sea: RealSea, tmp_path: Path) -> None:
    sea.connect(Udp(), Line(tmp_path / "ttyUSB0", 9600), Udp())
    sea.start()
    sea.enter_formation()
    sea.run(3.0)
    sea.messages[1].clear()
    ages_ms: list[int] = []

    def told() -> bool:
        while sea.messages[1]:
            message = sea.messages[1].pop(0)
            if message.get_type() == "ATTITUDE":
                ages_ms.append(sea.named("ATTITUDE")[-1].time_boot_ms - message.time_boot_ms)
        return len(ages_ms) > 10

    sea.until(told)
    print(f"ATTITUDE on 9600 Bd: oldest {max(ages_ms)} ms")
    assert max(ages_ms) < 1000


def test_a_serial_port_that_vanishes_does_not_stop_the_boat_and_is_opened_again(
    sea: RealSea, tmp_path: Path
) -> None:
    serial = Serial(tmp_path / "ttyUSB0")
    sea.connect(Udp(), serial, Udp())
    sea.start()
    sea.enter_formation()
    serial.close()
    sea.ends[1] = Udp()  # nobody
    commanded = len(sea.raw_commands())
    beats = len(sea.named("HEARTBEAT"))
    sea.until(lambda: len(sea.named("HEARTBEAT")) > beats)
    assert all(any(command) for command in some(sea.raw_commands()[commanded:]))
    assert sea.driven() and sea.state == "FORMATION"

    sea.ends[1].close()
    sea.ends[1] = Serial(tmp_path / "ttyUSB0")
    sea.messages[1].clear()
    sea.until(lambda: sea.named("HEARTBEAT", 1) and sea.named("ATTITUDE", 1))
    assert sea.driven()


def test_a_serial_port_that_nobody_reads_does_not_delay_the_boat(
    sea: RealSea, tmp_path: Path, opened: ExitStack
) -> None:
    deaf = Serial(tmp_path / "ttyS0")
    opened.callback(deaf.close)
    sea.start(f"--mavlink={deaf.option},rate=0", param=PATIENT | {"SR_STATE": 100})
    sea.enter_formation()
    sea.run(1.0)  # 8 kB: its buffer is full
    commanded = len(sea.raw_commands())
    sea.run(0.5)
    assert len(sea.raw_commands()) > commanded + 25
    assert sea.driven()


@pytest.mark.parametrize(
    ("absent", "why"),
    [
        ("udpin:203.0.113.77:14550", "Cannot assign requested address"),
        ("serial:/dev/null:57600", "Inappropriate ioctl for device"),
        ("serial:/dev/ttyNONE:57600", "No such file or directory"),
    ],
)
def test_a_boat_reports_a_link_that_does_not_open_and_sails_by_the_others(
    sea: RealSea, absent: str, why: str
) -> None:
    sea.connect(Udp(), Udp())
    sea.start(f"--mavlink={absent}")
    sea.enter_formation()
    assert f"flotillad: {absent} is not open: {why}" in sea.process.words.splitlines()
    assert "MAVLink link 2 is not open" in sea.texts()


def test_a_port_in_use_is_opened_when_it_becomes_free(sea: RealSea) -> None:
    port = free_port()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind((LOOPBACK, port))
        sea.connect(Udp(), Udp(port))
        sea.start()
        sea.until(lambda: "is not open: Address already in use" in sea.process.words)
        assert sea.named("HEARTBEAT", 0) and not sea.named("HEARTBEAT", 1)
    sea.until(lambda: sea.named("HEARTBEAT", 1))
    sea.until(lambda: f"udpin:{LOOPBACK}:{port} is open" in sea.process.words)


def test_a_serial_port_that_is_absent_at_the_start_is_opened_when_it_comes(
    sea: RealSea, tmp_path: Path, opened: ExitStack
) -> None:
    device = tmp_path / "ttyUSB0"
    sea.start(f"--mavlink=serial:{device}:115200")
    sea.enter_formation()
    late = Serial(device)
    opened.callback(late.close)
    heard: list[bytes] = []

    def chatter() -> bool:
        heard.extend(late.receive())
        return any(b"\xfd" in chunk for chunk in heard)

    sea.until(chatter)
