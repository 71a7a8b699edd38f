# SPDX-License-Identifier: MIT
"""MAVProxy tunes, arms and steers a boat."""

import re
from pathlib import Path

import flotilla
import pytest

from tests.clients.boat import BOTH_IDENTITIES, ESCS_SILENT, Sea, parameters
from tests.clients.mavproxy_client import MavProxy
from tests.turns import some


@pytest.fixture
def ready(mavproxy: MavProxy) -> MavProxy:
    mavproxy.until_it_says("online system 2", f"Received {len(parameters())} parameters")
    return mavproxy


def shown(words: str) -> dict[str, float]:
    """Parse the lines of `param show`: name and value."""
    lines = re.findall(r"^(?:\w+> )*([A-Z][A-Z0-9_]{2,15}) +(-?[0-9][0-9.e-]*)$", words, re.M)
    return {name: float(value) for name, value in lines}


@BOTH_IDENTITIES
def test_all_parameters_are_fetched(ready: MavProxy, autopilot: float) -> None:
    last = ready.tell("param show *", *parameters())
    ready.sea.beat()
    assert shown(ready.words) == pytest.approx(parameters(autopilot), rel=1e-6), last


def test_a_parameter_is_set_and_the_boat_has_it(sea: Sea, ready: MavProxy) -> None:
    ready.tell("param set LAW_KX 0.3")
    sea.until(lambda: sea.asked("LAW_KX") == pytest.approx(0.3))
    ready.tell("param show LAW_KX", "0.3000000")


def test_a_value_out_of_range_is_refused(sea: Sea, ready: MavProxy) -> None:
    default = parameters()["LAW_KX"]
    ready.tell("param set LAW_KX 9", "Failed to set LAW_KX to 9")
    assert sea.asked("LAW_KX") == pytest.approx(default)


@BOTH_IDENTITIES
def test_the_operator_arms_enters_formation_holds_and_disarms(sea: Sea, ready: MavProxy) -> None:
    sea.until(lambda: sea.armable)
    ready.tell("arm throttle", "ARMED")
    sea.until(lambda: sea.armed)
    ready.tell("mode FOLLOW", "Mode FOLLOW")
    sea.until(lambda: sea.state == "FORMATION" and sea.driven())
    ready.tell("mode HOLD", "Mode HOLD")
    sea.until(lambda: sea.state == "HOLD")
    ready.tell("disarm", "DISARMED")
    sea.until(lambda: not sea.armed)


@BOTH_IDENTITIES
@pytest.mark.parametrize("mode", ["FOLLOW", "HOLD", "MANUAL", "6", "AUTO", "STEERING"])
def test_a_mode_is_entered_or_refused_with_a_sentence(sea: Sea, ready: MavProxy, mode: str) -> None:
    sea.until(lambda: sea.armable)
    ready.tell("arm throttle", "ARMED")
    answer = {
        "FOLLOW": "Mode FOLLOW",
        "6": "Mode FOLLOW",
        "HOLD": "COMMAND_ACK: DO_SET_MODE: ACCEPTED",
        "AUTO": "Refused: no plan, or it cannot be sailed now",
        "MANUAL": "Refused: no MANUAL_CONTROL or RC input",
    }.get(mode, "Refused: use mode 0, 4, 5, 6, 10, 11 or 15")
    ready.tell(f"mode {mode}", answer)
    formation = mode in {"FOLLOW", "6"}
    sea.until(lambda: sea.state == ("FORMATION" if formation else "HOLD"))
    if not formation:
        sea.beat()
        assert not sea.driven()


@BOTH_IDENTITIES
def test_a_boat_is_sent_to_a_place_waits_and_is_called_home(sea: Sea, ready: MavProxy) -> None:
    sea.until(lambda: sea.armable)
    ready.tell("arm throttle", "ARMED")
    for mode in ("LOITER", "RTL", "GUIDED"):
        ready.tell(f"mode {mode}", f"Mode {mode}")
        sea.until(lambda mode=mode: sea.state == mode)
    ready.tell("guided 47.3977 8.5456 0", "COMMAND_ACK: DO_REPOSITION: ACCEPTED")
    sea.until(lambda: sea.state == "GUIDED" and sea.driven())
    ready.tell("guided 47.5 8.5456 0", "Refused: target is over 2.9 km away")


def test_a_saved_parameter_file_starts_no_boat(sea: Sea, ready: MavProxy, tmp_path: Path) -> None:
    """The file is saved in FOLLOW and loaded in HOLD; an old file contains the mode."""
    file = tmp_path / "boat.parm"
    sea.until(lambda: sea.armable)
    ready.tell("arm throttle", "ARMED")
    ready.tell("mode FOLLOW", "Mode FOLLOW")
    sea.until(lambda: sea.state == "FORMATION" and sea.driven())
    ready.tell(f"param save {file}", "Saved")
    ready.tell("mode HOLD", "Mode HOLD")
    sea.until(lambda: sea.state == "HOLD" and not sea.driven())
    ready.tell("param set LAW_KX 0.3")
    sea.until(lambda: sea.asked("LAW_KX") == pytest.approx(0.3))
    # MAVProxy loads only what differs from what it has heard, which may be late.
    sea.until(
        lambda: 0.29 < shown(ready.tell("param show LAW_KX", "LAW_KX")).get("LAW_KX", 0) < 0.31
    )
    before = len(sea.raw_commands())
    with file.open("a") as old:
        old.write("MODE 6\n")
    ready.tell(f"param load {file}", "Loaded")
    sea.until(lambda: sea.asked("LAW_KX") == parameters()["LAW_KX"])
    for _ in range(3):
        sea.beat()
        assert sea.state == "HOLD"
    assert set(some(sea.raw_commands()[before:])) == {(0, 0)}


@pytest.mark.usefixtures("escs_silent")
def test_the_operator_reads_why_the_boat_does_not_arm(sea: Sea, ready: MavProxy) -> None:
    ready.tell("arm throttle", ESCS_SILENT)
    sea.beat()
    assert not sea.ever_armed


def test_the_boats_files_are_listed(ready: MavProxy) -> None:
    words = ready.tell("ftp list", "Total size")
    for name, content in some(flotilla.metadata().items()):
        assert re.search(rf"{re.escape(name)}\s+{len(content)}\b", words), words
