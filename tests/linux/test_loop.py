# SPDX-License-Identifier: MIT
"""flotillad as a process: start, end, kill, standstill, and its cost."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from sil.live.free_port import free_port
from tests.linux.process import LOOPBACK, PATIENT, RealSea, Udp, now_us
from tests.target.bus import (
    ARMING_STATUS,
    GET_NODE_INFO,
    NODE,
    NODE_STATUS,
    RAW_COMMAND,
    TOOL,
    commands,
    node_info_request,
    of_type,
    transfers,
    type_of,
)
from tests.target.stations import (
    ARM,
    BOAT,
    FORMATION,
    SET_MODE,
    TEMPORARILY_REJECTED,
    command_long,
)

ESC_TIMEOUT_US = 250_000
LINUX_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def silence(sea: RealSea) -> None:
    """Silence everybody but the boat."""
    sea.own.on = sea.leader.on = sea.escs_on = False


def test_a_boat_alone_at_sea_starts_disarmed_and_sends_only_zeros(sea: RealSea) -> None:
    silence(sea)
    sea.start()
    sea.until(lambda: len(sea.frames(NODE_STATUS)) > 1)
    kinds = {type_of(can_id) for can_id, _ in sea.frames()}
    assert kinds == {(False, kind, NODE) for kind in (RAW_COMMAND, ARMING_STATUS, NODE_STATUS)}
    assert set(sea.raw_commands()) == {(0, 0)}
    assert set(sea.arming()) == {0}
    assert sea.state == "DISARMED"
    assert "ready: boat 2 on mcast" in sea.process.words


def test_raw_command_comes_at_the_control_rate_and_the_rest_at_theirs(sea: RealSea) -> None:
    silence(sea)
    sea.start(param=PATIENT | {"CTL_RATE": 200})
    sea.until(lambda: len(sea.frames(RAW_COMMAND)) > 300)
    seconds = 1e-6 * (sea.heard[-1].heard_us - sea.heard[0].heard_us)
    assert 100 < len(sea.frames(RAW_COMMAND)) / seconds < 250
    assert 5 < len(sea.frames(ARMING_STATUS)) / seconds < 15
    assert 0.5 < len(sea.frames(NODE_STATUS)) / seconds < 3


def test_dronecan_decodes_every_frame_and_gets_its_answer(sea: RealSea) -> None:
    silence(sea)
    sea.start()
    sea.until(sea.ready)
    for can_id, data in node_info_request(TOOL, NODE):
        sea.send_can(can_id, data)
    end_of_transfer = 0x40

    def answered() -> bool:
        return any(
            data[-1] & end_of_transfer
            for _, data in of_type(sea.frames(), GET_NODE_INFO, service=True)
        )

    sea.until(answered)
    sea.run(0.2)
    decoded = transfers(sea.frames())
    assert len(decoded) == sum(bool(data[-1] & end_of_transfer) for _, data in sea.frames())
    (info,) = [t for t in decoded if t.service_not_message]
    assert bytes(info.payload.name) == b"org.flotilla.autopilot"
    assert (info.source_node_id, info.dest_node_id) == (NODE, TOOL)


def test_a_heartbeat_comes_on_every_link_each_with_sequence_numbers_of_its_own(
    sea: RealSea,
) -> None:
    silence(sea)
    sea.connect(Udp(), Udp(), Udp())
    sea.start()
    sea.until(sea.ready)
    for _ in range(5):
        sea.say(command_long(ARM, 1.0), link=1)
    sea.until(lambda: len(sea.acks(1)) == 5)
    sea.until(lambda: all(len(sea.named("HEARTBEAT", link)) > 1 for link in range(3)))
    assert sea.acks(0) == sea.acks(2) == []
    assert sea.acks(1) == [(ARM, TEMPORARILY_REJECTED)] * 5
    for link in range(3):
        sequence = [m.get_seq() for m in sea.messages[link]]
        assert sequence == [n % 256 for n in range(len(sequence))]
        assert {(m.get_srcSystem(), m.get_srcComponent()) for m in sea.messages[link]} == {
            (BOAT, 1)
        }


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_flotillad_terminated_under_way_sends_zeros_and_disarms(
    sea: RealSea, number: signal.Signals
) -> None:
    sea.start()
    sea.enter_formation()
    assert sea.arming()[-1] == 255
    assert sea.end(number) == 0
    sent = sea.frames(RAW_COMMAND, ARMING_STATUS)
    driven = [f in of_type([f], RAW_COMMAND) and any(commands([f])) for f in sent]
    farewell = sent[len(sent) - driven[::-1].index(True) :]
    zeros = [commands([f]) for f in of_type(farewell, RAW_COMMAND)]
    assert len(zeros) >= 5 and set(zeros) == {(0, 0)}
    assert {data[0] for _, data in of_type(farewell, ARMING_STATUS)} == {0}
    assert not sea.driven()
    parameters = (sea.state_dir / "parameters.txt").read_text()
    assert parameters.startswith("flotilla-parameters 1\n")


def test_a_boat_whose_terminal_closes_sails_on(sea: RealSea) -> None:
    sea.start()
    sea.enter_formation()
    sea.process.signal(signal.SIGHUP)
    sea.forget()
    sea.until(lambda: len(sea.raw_commands()) > 50 and sea.state == "FORMATION")
    assert sea.driven()
    assert sea.end() == 0


def test_arming_while_flotillad_terminates_has_no_effect(sea: RealSea) -> None:
    sea.start()
    sea.arm()
    sea.process.signal(signal.SIGSTOP)
    sea.process.signal(signal.SIGTERM)
    for message in (command_long(ARM, 1.0), command_long(SET_MODE, 1.0, float(FORMATION))) * 2:
        sea.say(message)
    assert sea.end(signal.SIGCONT) == 0
    assert sea.arming()[-1] == 0
    assert set(sea.raw_commands()[-5:]) == {(0, 0)}


def test_a_boat_killed_while_driving_falls_silent_and_its_escs_stop(sea: RealSea) -> None:
    sea.start(param=PATIENT | {"CAN_NODE": 33, "LAW_KX": 0.25})
    sea.until(lambda: sea.heard and sea.source_node() == 33)
    sea.save_parameters()
    saved = (sea.state_dir / "parameters.txt").read_text()
    assert "LAW_KX = 0.25\n" in saved
    sea.enter_formation()

    assert sea.end(signal.SIGKILL) == -signal.SIGKILL
    last_us = sea.heard[-1].heard_us
    assert any(esc.command(last_us) for esc in sea.escs)
    sea.until(lambda: not sea.driven())
    assert sea.heard[-1].heard_us == last_us
    assert not any(esc.command(last_us + ESC_TIMEOUT_US + 1) for esc in sea.escs)

    sea.start(param={})
    sea.until(lambda: sea.ready() and len(sea.arming()) > 3)
    assert not sea.armed and set(sea.arming()) == {0}
    assert set(sea.raw_commands()) == {(0, 0)}
    assert sea.source_node() == 33
    assert sea.end() == 0
    assert (sea.state_dir / "parameters.txt").read_text() == saved


def test_a_process_that_was_stopped_does_not_drive_on_stale_input(sea: RealSea) -> None:
    sea.start(param=PATIENT | {"FS_NAV_S": 1.0})
    sea.enter_formation()
    sea.process.signal(signal.SIGSTOP)
    sea.until(lambda: not sea.driven())
    before = len(sea.heard)
    sea.run(1.2)
    assert len(sea.heard) == before  # RawCommand and ArmingStatus stop with the loop

    sea.process.signal(signal.SIGCONT)
    sea.until(lambda: len(sea.heard) > before + 60)
    woken = [(can_id, data) for _, can_id, data in sea.heard[before:]]
    assert {commands([f]) for f in of_type(woken, RAW_COMMAND)} == {(0, 0)}
    assert sea.state == "HOLD"
    assert "HOLD: no recent navigation data" in sea.texts()

    sea.enter_formation()  # the operator says so


def test_a_process_that_was_stopped_for_long_is_in_fault(sea: RealSea) -> None:
    sea.start(param=PATIENT | {"FS_NAV_S": 1.0, "FS_ESC_S": 1.0})
    sea.enter_formation()
    sea.process.signal(signal.SIGSTOP)
    sea.run(1.2)
    before = len(sea.heard)
    sea.process.signal(signal.SIGCONT)
    sea.until(lambda: any(text.startswith("FAULT") for text in sea.texts()))
    sea.until(lambda: len(sea.heard) > before + 60)
    woken = [(can_id, data) for _, can_id, data in sea.heard[before:]]
    assert {commands([f]) for f in of_type(woken, RAW_COMMAND)} == {(0, 0)}
    assert {data[0] for _, data in of_type(woken, ARMING_STATUS)} == {0}


def test_a_boat_whose_output_pipe_is_full_sails_on(sea: RealSea) -> None:
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writer, bytes(4096))
    os.set_blocking(writer, True)
    sea.start(mouth=writer)  # the first word would wait for ever
    sea.enter_formation()
    assert sea.end() == 0
    os.close(writer)
    os.close(reader)


def test_a_boat_whose_output_pipe_was_closed_sails_on(sea: RealSea) -> None:
    reader, writer = os.pipe()
    sea.start(mouth=writer)
    os.close(writer)
    os.close(reader)
    sea.enter_formation()
    sea.say(command_long(ARM, 0.0))
    sea.until(lambda: not sea.armed)
    parameters = sea.state_dir / "parameters.txt"
    sea.insist(parameters.exists, 245, 1.0)  # and says so
    sea.enter_formation()
    assert sea.end() == 0


def test_a_second_controller_on_the_bus_is_a_fault_and_forbids_arming(sea: RealSea) -> None:
    sea.start()
    sea.enter_formation()
    can_id, data = sea.frames(RAW_COMMAND)[0]

    def interfere() -> None:
        sea.send_can(can_id & ~0x7F | 99, data)

    interfere()
    sea.until(lambda: "FAULT: another controller on the CAN bus" in sea.texts())
    sea.until(lambda: not sea.driven())
    sea.until(lambda: sea.arming()[-1] == 0)

    def interfere_and_arm() -> None:
        interfere()
        sea.say(command_long(ARM, 1.0))

    sea.insist(lambda: "DISARMED" in sea.texts(), ARM, 0.0)
    refusal = "PreArm: another controller on the CAN bus"
    sea.repeat(interfere_and_arm, lambda: refusal in sea.texts())
    assert not sea.armed


# The kernel splits each send into 40 datagrams (UDP_SEGMENT); otherwise Python is too slow.
FLOOD = """
import pathlib, socket, sys
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as flood:
    flood.connect(("127.0.0.1", int(sys.argv[1])))
    flood.setsockopt(socket.IPPROTO_UDP, 103, 1400)
    datagrams = bytes([0xFD]) * 1400 * 40
    flood.send(datagrams)
    pathlib.Path(sys.argv[2]).touch()
    while True:
        flood.send(datagrams)
"""


def test_a_flood_on_one_link_does_not_stop_the_control_loop(sea: RealSea) -> None:
    port, rising = free_port(), sea.folder / "rising"
    sea.start(f"--mavlink=udpin:{LOOPBACK}:{port}")
    sea.enter_formation()
    with subprocess.Popen([sys.executable, "-c", FLOOD, str(port), rising]) as flood:
        try:
            sea.until(rising.exists)
            before = len(sea.raw_commands())
            sea.until(lambda: len(sea.raw_commands()) > before + 150)
            assert flood.poll() is None
            assert sea.driven()
        finally:
            flood.kill()
    assert sea.end() == 0


def cpu_s(pid: int) -> float:
    """User and system time so far, s: proc(5)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / LINUX_TICKS_PER_S


def memory_kB(pid: int, which: str) -> int:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(which))


def test_a_driving_boat_needs_little_of_the_computer(
    sea: RealSea, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sea.connect(Udp(), Udp())
    sea.start(f"--log={tmp_path / 'log'}")
    sea.enter_formation()
    pid, began_us, began_s = sea.process.pid, now_us(), cpu_s(sea.process.pid)
    sea.run(5.0)
    share = (cpu_s(pid) - began_s) / (1e-6 * (now_us() - began_us))
    resident_kB, most_kB = memory_kB(pid, "VmRSS"), memory_kB(pid, "VmHWM")
    with capsys.disabled():
        print(f"\nflotillad at 100 Hz: {100 * share:.1f} % CPU, {resident_kB} kB, most {most_kB}")
    assert sea.driven()
    assert most_kB < 10_000
    assert share < 0.1
