# SPDX-License-Identifier: MIT
"""flotillad on the kernel's CAN, and that bus's faults."""

import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from sil.wire.esc_node import COMMAND_TIMEOUT_US
from tests.flotillad import needs_flotillad
from tests.target.bus import (
    ARMING_STATUS,
    GET_NODE_INFO,
    NODE,
    NODE_STATUS,
    RAW_COMMAND,
    TOOL,
    Frames,
    arming_statuses,
    commands,
    node_info_request,
    of_type,
    transfers,
    type_of,
)
from tests.vcan.boat import Boat
from tests.vcan.bus import INTERFACE, URGENT, Can, Candump, run
from tests.vcan.conftest import Shape

CAN_ERR_BUSOFF, CAN_ERR_RESTARTED = 0x40, 0x100

Log = list[tuple[float, int, bytes]]  # s, identifier, data

#: Another controller's commands, in the notation of can-utils.
FOREIGN = {"RawCommand": "0704062A#641900C0", "ArmingStatus": "18044C2A#FFC0"}


@pytest.fixture(autouse=True, scope="module")
def _program() -> None:
    needs_flotillad()


@pytest.fixture
def boat(tmp_path: Path) -> Iterator[Boat]:
    """A disarmed boat that is fit to arm."""
    with Boat(tmp_path) as boat:
        yield boat


def add_interface() -> None:
    run("ip", "link", "add", INTERFACE, "type", "vcan")
    run("ip", "link", "set", INTERFACE, "up")


@pytest.fixture
def _whole_interface() -> Iterator[None]:
    """Restores the interface after each test."""
    yield
    if INTERFACE not in {name for _, name in socket.if_nameindex()}:
        add_interface()
    run("ip", "link", "set", INTERFACE, "up")


def send_error(kind: int) -> None:
    """Send an error frame, as a CAN controller's driver does."""
    with closing(Can([])) as can:
        can.send_raw(socket.CAN_ERR_FLAG | kind, bytes(8))


def expect_fault(boat: Boat, why: str) -> None:
    boat.wait(lambda: boat.state == "FAULT", "FAULT")
    assert boat.texts[-1] == f"FAULT: {why}"
    boat.wait(boat.rests, "rest")


def expect_refusal(boat: Boat, why: str) -> None:
    """Wait for a refusal with its reason; only the first of several has one."""
    heard = len(boat.texts)
    assert not boat.arm()
    assert boat.texts[heard:] in ([], [f"PreArm: {why}"])
    assert boat.state in ("DISARMED", "FAULT")


def of_boat(frames: Frames) -> Frames:
    return [frame for frame in frames if type_of(frame[0])[2] == NODE]


def check_all_is_rest(frames: Frames) -> None:
    """Only zeros, ArmingStatus 0, NodeStatus and answers may appear."""
    kinds = {type_of(can_id)[:2] for can_id, _ in frames}
    assert kinds <= {
        (False, RAW_COMMAND),
        (False, ARMING_STATUS),
        (False, NODE_STATUS),
        (True, GET_NODE_INFO),
    }
    assert {commands([frame]) for frame in of_type(frames, RAW_COMMAND)} == {(0, 0)}
    assert set(arming_statuses(frames)) == {0}


@pytest.fixture(scope="module")
def outing(tmp_path_factory: pytest.TempPathFactory) -> Log:
    """candump's log of a boat: 1 s disarmed, 2 s in FORMATION, disarmed again, exit."""
    with Candump() as candump, Boat(tmp_path_factory.mktemp("outing")) as boat:
        for frame in node_info_request(TOOL, NODE):
            boat.can.send(*frame)
        boat.run(1.0)
        boat.enter_formation()
        boat.run(2.0)
        boat.disarm()
        boat.run(0.3)
        boat.stop()
        return candump.frames()


def test_candump_shows_raw_command_at_the_control_rate(outing: Log) -> None:
    times = [t_s for t_s, can_id, _ in outing if type_of(can_id) == (False, RAW_COMMAND, NODE)]
    assert len(times) > 300
    # The median: a busy machine makes a tick late or skips it.
    assert np.median(np.diff(times)) == pytest.approx(0.01, rel=0.1)


def test_pypi_dronecan_decodes_every_frame_on_the_bus(outing: Log) -> None:
    frames = [(can_id, data) for _, can_id, data in outing]
    complete = transfers(frames)
    assert len(complete) == sum(data[-1] >> 6 & 1 for _, data in frames)
    answers = [t for t in complete if t.service_not_message and not t.request_not_response]
    assert [str(answer.payload.name) for answer in answers] == ["org.flotilla.autopilot"]


def test_a_disarmed_boat_sends_only_zeros_arming_status_0_node_status_and_answers(
    outing: Log,
) -> None:
    own = of_boat([(can_id, data) for _, can_id, data in outing])
    arming = [k for k, frame in enumerate(own) if of_type([frame], ARMING_STATUS)]
    armed = [k for k in arming if arming_statuses([own[k]]) == [255]]
    after = next(k for k in arming if k > armed[-1])
    check_all_is_rest(own[: armed[0]])
    check_all_is_rest(own[after:])
    assert len(of_type(own[after:], RAW_COMMAND)) > 10
    assert any(any(commands([f])) for f in of_type(own[armed[0] : after], RAW_COMMAND))


@pytest.mark.parametrize("kind", FOREIGN)
def test_beside_another_controller_a_boat_neither_arms_nor_goes_on(boat: Boat, kind: str) -> None:
    why = "another controller on the CAN bus"
    boat.enter_formation()
    boat.execute("cansend", INTERFACE, FOREIGN[kind])
    expect_fault(boat, why)
    # ArmingStatus 0 stops the ESCs; the first RawCommand of zeros arrives after it.
    boat.wait(lambda: commands([boat.commands[-1][1]]) == (0, 0), "RawCommand of zeros")
    zeros = len(boat.commands)
    boat.run(0.2)
    assert {commands([frame]) for _, frame in boat.commands[zeros:]} == {(0, 0)}
    boat.disarm()
    expect_refusal(boat, why)
    boat.enter_formation()


@pytest.mark.parametrize("sign", ["the controller's restart", "traffic"])
def test_bus_off_is_a_fault_until_a_sign_of_life(boat: Boat, sign: str) -> None:
    boat.enter_formation()
    boat.escs_speak = False  # else they end it, as they cannot on a real bus
    send_error(CAN_ERR_BUSOFF)
    expect_fault(boat, "CAN bus is down")
    boat.disarm()
    expect_refusal(boat, "CAN bus is down")
    sent = len(boat.commands)
    boat.run(0.2)
    assert len(boat.commands) == sent
    if sign == "traffic":
        boat.escs_speak = True
    else:
        send_error(CAN_ERR_RESTARTED)
    boat.wait(lambda: len(boat.commands) > sent, "RawCommand")
    boat.escs_speak = True
    boat.enter_formation()
    can = boat.stop()["can"]
    assert (can["bus_off"], can["reopened"]) == (1, 0)
    assert can["error_frames"] == (1 if sign == "traffic" else 2)
    assert can["transfers_dropped"] > 20


@pytest.mark.usefixtures("_whole_interface")
def test_an_interface_that_goes_down_is_a_fault_and_serves_again_when_it_is_up(boat: Boat) -> None:
    boat.enter_formation()
    run("ip", "link", "set", INTERFACE, "down")
    expect_fault(boat, "CAN bus is down")
    boat.disarm()
    expect_refusal(boat, "CAN bus is down")
    run("ip", "link", "set", INTERFACE, "up")
    boat.enter_formation()
    can = boat.stop()["can"]
    assert can["transfers_dropped"] > 10 and (can["bus_off"], can["reopened"]) == (0, 0)


@pytest.mark.usefixtures("_whole_interface")
def test_an_interface_that_vanishes_is_a_fault_and_serves_again_when_it_is_back(boat: Boat) -> None:
    boat.enter_formation()
    run("ip", "link", "delete", INTERFACE)
    expect_fault(boat, "CAN bus is down")
    boat.disarm()
    expect_refusal(boat, "CAN bus is down")
    add_interface()
    boat.can.reopen()
    boat.enter_formation()
    can = boat.stop()["can"]
    assert can["transfers_dropped"] > 10 and (can["bus_off"], can["reopened"]) == (0, 1)


def test_a_full_queue_drops_whole_transfers_and_counts_them(boat: Boat, shape: Shape) -> None:
    boat.enter_formation()
    # A bus of 31 frames per second for the boat, where 10 may wait; the ESCs' frames pass by. Even
    # a busy machine, which skips ticks, sends more.
    bands = ["1"] * 16
    bands[URGENT] = "0"
    two = ["handle", "1:", "prio", "bands", "2", "priomap", *bands]
    shape(INTERFACE, *two, execute=boat.execute)
    slow = ["tbf", "rate", "4kbit", "burst", "32", "limit", "160"]
    boat.execute("tc", "qdisc", "add", "dev", INTERFACE, "parent", "1:2", "handle", "2:", *slow)
    assert 20 < boat.count_commands(1.5) < 75
    boat.stays("FORMATION")
    shape(INTERFACE, execute=boat.execute)
    assert 35 < boat.count_commands(1.0) < 115  # more than the slow bus has
    boat.stays("FORMATION")
    assert boat.drives()
    can = boat.stop()["can"]
    assert 10 < can["transfers_dropped"] < 250 and can["bus_off"] == 0


def test_a_bus_that_loses_every_tenth_frame_carries_a_formation(boat: Boat, shape: Shape) -> None:
    boat.enter_formation()
    shape(INTERFACE, "netem", "loss", "10%", execute=boat.execute)
    assert 0.03 < boat.share_lost(250) < 0.2
    # NodeStatus is sent once a second: three in a row are lost now and then.
    assert (
        boat.state == "FORMATION" or boat.texts[-1] == "FAULT: an ESC is offline or reports a fault"
    )
    assert boat.state == "FAULT" or boat.drives()
    shape(INTERFACE, execute=boat.execute)
    can = boat.stop()["can"]
    assert can["transfers_dropped"] == can["receive_overflows"] == 0
    assert can["received"] < boat.esc_frames - 20


def babble() -> "subprocess.Popen[bytes]":
    """Sends NodeStatus of a node 127 as fast as possible, at the lowest priority."""
    frame = ["-e", "-I", "1F01557F", "-L", "8", "-D", "i"]
    cangen = shutil.which("cangen") or "cangen"  # Boat.execute says why
    return subprocess.Popen([cangen, INTERFACE, "-g", "0", "-i", *frame])


def test_a_babbling_node_stops_a_boat_at_most_until_it_is_silent(boat: Boat) -> None:
    boat.enter_formation()
    babbler = babble()
    try:
        through = boat.count_commands(2.0)
    finally:
        babbler.kill()
        babbler.wait()
    assert through > 20  # fewer, and the ESCs would stop by themselves now and then
    late = {
        "COAST": [
            "COAST: leader lost or origin unknown",
            "COAST: leader latency unknown: set FORM_LAG_S",
        ],
        "HOLD": [
            "HOLD: no recent navigation data",
            "HOLD: navigation lag unknown: set NAV_LAG_S",
            "HOLD: FS_COAST_S elapsed, or position lost",
        ],
        "FAULT": ["FAULT: an ESC is offline or reports a fault"],
    }
    assert boat.state == "FORMATION" or boat.texts[-1] in late[str(boat.state)]
    boat.disarm()
    boat.enter_formation()
    assert 30 < boat.count_commands(0.5) < 60
    assert boat.stop()["can"]["received"] > 3000


def test_after_kill_9_the_bus_is_silent_and_the_escs_stop_by_themselves(boat: Boat) -> None:
    boat.enter_formation()
    boat.kill()
    boat.run(0.05)
    last_us, silent = boat.commands[-1][0], len(boat.commands)
    assert all(esc.command(last_us + COMMAND_TIMEOUT_US) for esc in boat.escs)
    boat.run(0.3)
    assert len(boat.commands) == silent and boat.rests()
    boat.start()
    assert boat.state == "DISARMED"
    boat.enter_formation()
