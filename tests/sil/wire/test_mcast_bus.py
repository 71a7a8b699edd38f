# SPDX-License-Identifier: MIT
"""CAN in UDP multicast: against recorded packets, plain sockets and pydronecan's own driver."""

import asyncio
import json
import os
import socket
import struct
import subprocess
import sys
from binascii import crc_hqx
from collections.abc import Callable, Iterator
from importlib.metadata import entry_points
from pathlib import Path

import can
import pytest
from dronecan.driver.common import CANFrame
from dronecan.driver.mcast import mcast
from hypothesis import given
from hypothesis import strategies as st

from sil.wire.mcast_bus import PORT, McastBus, pack, unpack

VECTORS = json.loads((Path(__file__).parents[2] / "reference/dronecan_vectors.json").read_text())
# Buses that a second run of the tests does not use, and nobody's 0 to 9.
BUS = 10 + 2 * (os.getpid() % 120)
GROUP = f"239.65.82.{BUS}"
LOOPBACK = socket.inet_aton("127.0.0.1")
WAIT_S = 5.0
IP_PKTINFO, IP_RECVTTL = 8, 12  # linux/in.h; Python's socket has not all
RAW_COMMAND = can.Message(arbitration_id=0x0704060A, data=bytes.fromhex("FF7C0200C1"))

Open = Callable[[str], McastBus]


@pytest.fixture
def on() -> Iterator[Open]:
    """Opens buses that are closed after the test."""
    buses: list[McastBus] = []

    def on(channel: str) -> McastBus:
        buses.append(McastBus(channel))
        return buses[-1]

    yield on
    for bus in buses:
        bus.shutdown()


@pytest.fixture
def sender() -> Iterator[socket.socket]:
    """A plain socket that sends to the bus."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, LOOPBACK)
        udp.connect((GROUP, PORT))
        yield udp


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    """A plain socket that receives the bus, with interface and TTL of each packet."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        udp.setsockopt(socket.IPPROTO_IP, IP_RECVTTL, 1)
        udp.setsockopt(socket.IPPROTO_IP, IP_PKTINFO, 1)
        udp.bind((GROUP, PORT))
        membership = socket.inet_aton(GROUP) + LOOPBACK
        udp.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        udp.settimeout(WAIT_S)
        yield udp


def packet_of(can_id: int, data: bytes, flags: int = 0, magic: int = 0x2934) -> bytes:
    """A packet with a valid CRC and arbitrary content."""
    body = struct.pack("<HI", flags, can_id) + data
    return struct.pack("<HH", magic, crc_hqx(body, 0xFFFF)) + body


def content(message: can.Message | None) -> tuple[int, bool, bytes]:
    """A frame's identifier, format and data."""
    assert message is not None, "no frame came"
    return message.arbitration_id, message.is_extended_id, bytes(message.data)


@pytest.mark.parametrize("vector", VECTORS["udp_multicast"], ids=lambda v: v["can_id"])
def test_recorded_packets_are_sent_and_received_byte_for_byte(
    on: Open, sender: socket.socket, listener: socket.socket, vector: dict[str, str]
) -> None:
    can_id, data = int(vector["can_id"], 16), bytes.fromhex(vector["data"])
    packet = bytes.fromhex(vector["packet"])
    bus = on(str(BUS))
    bus.send(can.Message(arbitration_id=can_id, data=data))
    assert listener.recv(100) == packet
    sender.send(packet)
    assert content(bus.recv(WAIT_S)) == (can_id, True, data)


@given(st.data(), st.booleans(), st.binary(max_size=8))
def test_any_classic_frame_survives_a_packet(
    draw: st.DataObject, extended: bool, data: bytes
) -> None:
    can_id = draw.draw(st.integers(0, (1 << (29 if extended else 11)) - 1))
    frame = can.Message(arbitration_id=can_id, is_extended_id=extended, data=data)
    read = unpack(pack(frame), 0.0)
    assert isinstance(read, can.Message)
    assert content(read) == (can_id, extended, data)


@given(st.binary(max_size=20))
def test_any_bytes_are_a_frame_or_have_a_reason_not_to_be(packet: bytes) -> None:
    read = unpack(packet, 0.0)
    assert isinstance(read, can.Message) or read in {"malformed", "crc", "fd"}


def test_two_buses_of_one_number_talk_and_none_hears_itself(on: Open) -> None:
    boat, esc = on(str(BUS)), on(str(BUS))
    boat.send(RAW_COMMAND)
    assert content(esc.recv(WAIT_S)) == content(RAW_COMMAND)
    answer = can.Message(arbitration_id=0x10040A15, data=b"\x15\x00\x40")
    esc.send(answer)
    assert content(boat.recv(WAIT_S)) == content(answer), "and not its own RawCommand before"
    assert esc.recv(0) is None


def test_another_bus_number_is_another_bus(on: Open) -> None:
    boat_1, boat_2, esc_1 = on(str(BUS)), on(str(BUS + 1)), on(str(BUS))
    boat_2.send(RAW_COMMAND)
    esc_1.send(can.Message(arbitration_id=1, data=b""))
    boat_1.send(can.Message(arbitration_id=2, data=b""))
    assert content(boat_1.recv(WAIT_S))[0] == 1
    assert content(esc_1.recv(WAIT_S))[0] == 2
    assert boat_2.recv(0) is None


def test_garbage_is_counted_and_the_next_frame_arrives(on: Open, sender: socket.socket) -> None:
    bus = on(str(BUS))
    good = packet_of(1 << 31 | 0x0704060A, b"\x00\xc0")
    damaged = good[:-1] + b"\xc1"
    for garbage in (
        b"",
        good[:9],
        b"hello, is this the harbour office?",
        packet_of(1 << 31, b"", magic=0x2935),
        packet_of(1 << 31, bytes(9)),
        packet_of(0x800, b""),
        packet_of(1 << 31 | 1 << 29, b""),
        damaged,
        packet_of(1 << 31, bytes(64), flags=1),
        bytes(2000),
    ):
        sender.send(garbage)
    sender.send(good)
    assert content(bus.recv(WAIT_S)) == (0x0704060A, True, b"\x00\xc0")
    assert bus.counters == {"malformed": 8, "crc": 1, "fd": 1}


@pytest.mark.parametrize(("address", "ttl"), [("", 0), (":127.0.0.1", 1)])
def test_without_an_address_no_packet_leaves_the_machine(
    on: Open, listener: socket.socket, address: str, ttl: int
) -> None:
    on(f"{BUS}{address}").send(RAW_COMMAND)
    _, ancillary, _, source = listener.recvmsg(100, 200)
    said = {kind: value for _, kind, value in ancillary}
    assert struct.unpack("i", said[socket.IP_TTL]) == (ttl,)
    assert struct.unpack("i", said[IP_PKTINFO][:4]) == (socket.if_nametoindex("lo"),)
    assert source[0] == "127.0.0.1"


@pytest.mark.parametrize("channel", ["", "x", "256", "-1", "0:", "0:lo", "0:127.0.0.1:1"])
def test_a_wrong_channel_is_named(channel: str) -> None:
    with pytest.raises(can.CanInitializationError, match=f"mcast:{channel}"):
        McastBus(channel)


def test_an_address_that_is_not_ours_is_named() -> None:
    with pytest.raises(can.CanInitializationError, match=r"mcast:0:192\.0\.2\.1: .*assign"):
        McastBus("0:192.0.2.1")


@pytest.mark.parametrize("kind", ["is_fd", "is_remote_frame", "is_error_frame"])
def test_a_frame_that_is_no_classic_data_frame_is_refused(on: Open, kind: str) -> None:
    with pytest.raises(can.CanOperationError, match="classic data frames"):
        on(str(BUS)).send(can.Message(arbitration_id=1, **{kind: True}))


def test_filters_of_python_can_apply(on: Open) -> None:
    bus, boat = on(str(BUS)), on(str(BUS))
    bus.set_filters([{"can_id": 0x040600, "can_mask": 0xFFFF00, "extended": True}])
    boat.send(can.Message(arbitration_id=0x1401550A, data=b"\xc0"))
    boat.send(RAW_COMMAND)
    assert content(bus.recv(WAIT_S)) == content(RAW_COMMAND)


def test_a_notifier_waits_on_the_bus_in_an_event_loop(on: Open) -> None:
    bus, boat = on(str(BUS)), on(str(BUS))

    async def listen() -> can.Message:
        reader = can.AsyncBufferedReader()
        notifier = can.Notifier(bus, [reader], loop=asyncio.get_running_loop())
        try:
            boat.send(RAW_COMMAND)
            return await asyncio.wait_for(reader.get_message(), WAIT_S)
        finally:
            notifier.stop()

    assert content(asyncio.run(listen())) == content(RAW_COMMAND)


def test_a_closed_bus_has_no_socket_left(on: Open) -> None:
    bus = on(str(BUS))
    bus.shutdown()
    bus.shutdown()
    assert bus.fileno() == -1


def test_python_can_knows_the_backend_by_name() -> None:
    (backend,) = entry_points(group="can.interface", name="mcast")
    assert backend.load() is McastBus
    with can.Bus(interface="mcast", channel=str(BUS)) as bus:
        assert isinstance(bus, McastBus)


def test_the_logger_of_python_can_shows_the_bus(on: Open) -> None:
    command = [
        "timeout",
        "20",
        sys.executable,
        "-u",
        "-m",
        "can.logger",
        "-i",
        "mcast",
        "-c",
        str(BUS),
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as logger:
        try:
            assert logger.stdout is not None
            for line in logger.stdout:
                if line.startswith("Can Logger"):  # it listens from here on
                    on(str(BUS)).send(RAW_COMMAND)
                if "0704060a" in line:
                    assert "ff 7c 02 00 c1" in line
                    break
            else:
                pytest.fail("the logger ended without the frame")
        finally:
            logger.terminate()


@pytest.fixture
def pydronecan() -> Iterator[mcast]:
    """pydronecan's driver of the bus: a process, on the interface of the default route."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        try:
            udp.connect((GROUP, PORT))
        except OSError as error:
            pytest.skip(f"pydronecan's driver needs a route to {GROUP}: {error}")
    driver = mcast(str(BUS))
    yield driver
    driver.proc.terminate()
    driver.proc.join()
    driver.proc.close()
    for queue in (driver.rx_queue, driver.tx_queue):
        queue.close()
        queue.join_thread()


def test_pydronecan_hears_us_and_we_hear_it(on: Open, pydronecan: mcast) -> None:
    bus = on(str(BUS))
    pydronecan.send_frame(CANFrame(0x10040A15, b"\x15\x00\x40", True))
    assert content(bus.recv(WAIT_S)) == (0x10040A15, True, b"\x15\x00\x40")
    bus.send(RAW_COMMAND)
    heard = pydronecan.receive(WAIT_S)
    assert heard is not None
    assert (heard.id, heard.extended, bytes(heard.data)) == content(RAW_COMMAND)
