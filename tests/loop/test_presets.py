# SPDX-License-Identifier: MIT
"""Fleets of the named hulls keep their slots as well as they did, give or take a factor of two."""

from functools import cache

import pytest

from sil.certificate.references import references
from sil.scenario import presets as hulls
from sil.scenario import scenario
from tests.each_push import few
from tests.loop import presets
from tests.loop.gains import certificate

TARGET_M = {"calm": 0.05, "weather": 0.15}

# As `python -m tests.loop.presets` prints it, m.
MEASURED = {
    ("blueboat", "calm"): 0.0160,
    ("blueboat", "weather"): 0.0210,
    ("heron", "calm"): 0.0288,
    ("heron", "weather"): 0.0357,
    ("otter", "calm"): 0.0030,
    ("otter", "weather"): 0.0133,
    ("paper", "calm"): 0.0001,
    ("paper", "weather"): 0.0152,
    ("wamv", "calm"): 0.0141,
    ("wamv", "weather"): 0.0199,
    ("mixed", "calm"): 0.0154,
    ("mixed", "weather"): 0.0198,
}


# All hulls but one are in the mixed fleet.
EACH_PUSH = [("mixed", "calm"), ("mixed", "weather"), ("wamv", "weather")]


@cache
def rms_m(fleet: str, weather: str) -> float:
    return presets.measured({}, [(fleet, weather)])[fleet, weather]


def test_every_hull_is_sailed() -> None:
    assert presets.fleets().keys() == MEASURED.keys()


@pytest.mark.parametrize(("fleet", "weather"), few(MEASURED, EACH_PUSH))
def test_fleet_of_a_named_hull_stays_in_its_slots(fleet: str, weather: str) -> None:
    assert rms_m(fleet, weather) < 2.0 * MEASURED[fleet, weather]
    assert rms_m(fleet, weather) <= TARGET_M[weather]


def test_mixed_fleet_stays_within_a_tenth_of_a_metre() -> None:
    assert rms_m("mixed", "calm") <= 0.10


@pytest.mark.parametrize("name", few([*hulls.names(), "mixed"], ["heron", "otter"]))
def test_certificate_holds_with_the_gains_that_the_firmware_derives(name: str) -> None:
    fleet = scenario.load("mixed", [] if name == "mixed" else presets.alike(name))
    assert certificate(fleet).startswith("holds, 0.0")


def test_virtual_heron_sails_in_circles_and_the_leader_of_these_fleets_does_not() -> None:
    turning = ("leader.input.1.yaw_sine_Nm=2.0", "leader.input.1.yaw_sine_rad_s=0.25")
    (circles,) = references(
        scenario.load("mixed", ["hull=heron", "leader.input.1.surge_N=13", *turning])
    )
    (curve,) = references(scenario.load("mixed", presets.alike("heron")))
    assert abs(circles.motion.drift[2]) > 6.0
    assert abs(curve.motion.drift[2]) < 1e-6
