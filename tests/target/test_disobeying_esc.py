# SPDX-License-Identifier: MIT
"""An ESC that spins its propeller while commanded to stop."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from tests.target.bus import Esc, Frames, esc_status
from tests.target.sea import Sea, texts


@dataclass
class Willful(Esc):
    """Reports its own speed at 10 Hz, whatever it is commanded."""

    rpm: int = 0
    power_pct: int = 0

    def frames(self, now_us: int) -> Frames:
        due = now_us >= self.next_status_us
        frames = super().frames(now_us)
        if not due:
            return frames
        said: dict[str, float] = {"rpm": self.rpm, "power_rating_pct": self.power_pct}
        said |= {"voltage": float("nan"), "current": float("nan"), "temperature": float("nan")}
        status = esc_status(self.node, self.index, self.sent % 32, **said)
        return status + frames[len(status) :]


def bus() -> tuple[Sea, Willful]:
    sea = Sea()
    esc = Willful(31, 0)
    sea.escs[0] = esc
    sea.run(2.0)
    assert sea.condition("escs_obey") and sea.condition("escs_online")
    return sea, esc


def test_a_boat_whose_esc_drives_while_disarmed_is_not_armed() -> None:
    sea, esc = bus()
    esc.power_pct = 50
    sea.run(0.4)
    assert sea.condition("escs_obey")
    sea.run(0.4)
    assert not sea.condition("escs_obey")
    sea.arm()
    assert sea.state == "DISARMED"
    assert any(t.startswith("PreArm: ") and "ESC" in t for t in texts(sea.ticks))
    esc.power_pct = 0
    sea.run(0.9)
    assert not sea.condition("escs_obey")
    sea.run(0.3)
    assert sea.condition("escs_obey")
    sea.arm()
    assert sea.state == "HOLD"


def test_an_esc_that_drives_in_hold_causes_a_fault_and_is_disarmed() -> None:
    sea, esc = bus()
    sea.arm()
    sea.run(1.0)
    esc.power_pct = 30
    sea.run(0.8)
    assert sea.state == "FAULT"
    assert [status for tick in sea.run(0.3) for status in tick.arming][-1] == 0


@pytest.mark.parametrize("rpm", [2000, -2000])
def test_a_shaft_that_turns_for_5_s_without_a_command_counts_as_driven(rpm: int) -> None:
    sea, esc = bus()
    esc.rpm = rpm
    sea.run(4.9)
    assert sea.condition("escs_obey")  # water may turn it
    sea.run(0.4)
    assert not sea.condition("escs_obey")


def test_a_slowly_turning_shaft_counts_as_turned_by_the_water() -> None:
    sea, esc = bus()
    esc.rpm = 250
    sea.run(60.0)
    assert sea.condition("escs_obey")
