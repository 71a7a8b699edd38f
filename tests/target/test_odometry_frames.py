# SPDX-License-Identifier: MIT
"""The frames of ODOMETRY: legal pairs are rotated, all others rejected and reported."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from tests.target.course import Course, quaternion, wrap
from tests.target.sea import Sea, named, texts
from tests.target.stations import odometry, origin

#: Maps north-east-down to east-north-up.
P = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def product(a: list[float], b: list[float]) -> list[float]:
    aw, (ax, ay, az) = a[0], a[1:]
    bw, (bx, by, bz) = b[0], b[1:]
    return [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]


@pytest.mark.parametrize("frame", [1, 4], ids=["LOCAL_NED", "LOCAL_ENU"])
@pytest.mark.parametrize(
    "child", [12, 8, 1, 4], ids=["BODY_FRD", "BODY_NED", "LOCAL_NED", "LOCAL_ENU"]
)
@pytest.mark.parametrize("tilt", [0.0, 0.2], ids=["level", "tilted"])
def test_odometry_is_rotated_by_its_frames(frame: int, child: int, tilt: float) -> None:
    rng = random.Random(frame * 100 + child)
    for _ in range(10):
        sea = Sea(own=Course())
        truth = Course(rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-3.1, 3.1))
        roll, pitch = rng.uniform(-tilt, tilt), rng.uniform(-tilt, tilt)
        velocity_n = np.array([rng.uniform(-2, 2), rng.uniform(-2, 2), 0.0])
        q, position = quaternion(roll, pitch, truth.psi), np.array([truth.north, truth.east, 0.0])
        if frame == 4:
            half = math.sqrt(0.5)
            q, position = product([0.0, half, half, 0.0], q), P @ position
        velocity = {
            12: rotation(roll, pitch, truth.psi).T @ velocity_n,
            8: rotation(roll, pitch, truth.psi).T @ velocity_n,
            1: velocity_n,
            4: P @ velocity_n,
        }[child]
        x, y, z = position
        vx, vy, vz = velocity
        wire = {"x": x, "y": y, "z": z, "vx": vx, "vy": vy, "vz": vz, "q": q}
        sea.own.on = False
        sea.say(
            odometry(truth, sea.now_us, frame_id=frame, child_frame_id=child, **wire),
            sender=sea.own.station,
        )
        sea.step()
        told = named(sea.ticks, "LOCAL_POSITION_NED")[-1]
        assert (told.x, told.y) == pytest.approx((truth.north, truth.east), abs=1e-4)
        assert (told.vx, told.vy) == pytest.approx(tuple(velocity_n[:2]), abs=1e-4)
        assert wrap(named(sea.ticks, "ATTITUDE")[-1].yaw - truth.psi) == pytest.approx(
            0.0, abs=1e-4
        )


@pytest.mark.parametrize("child", [12, 1])
def test_the_yaw_rate_of_odometry_is_kept(child: int) -> None:
    for frame, psi, rate in ((1, 0.4, 0.3), (4, -2.0, -0.2)):
        sea = Sea()
        sea.own.on = False
        q = quaternion(0, 0, psi)
        q = q if frame == 1 else product([0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0], q)
        sea.say(
            odometry(
                Course(0, 0, psi, r=rate), sea.now_us, frame_id=frame, child_frame_id=child, q=q
            ),
            sender=sea.own.station,
        )
        sea.step()
        assert named(sea.ticks, "ATTITUDE")[-1].yawspeed == pytest.approx(rate)


@pytest.mark.parametrize("frame", [20, 21], ids=["LOCAL_FRD", "LOCAL_FLU"])
def test_a_frame_that_is_not_north_aligned_is_refused_and_reported(sea: Sea, frame: int) -> None:
    sea.own.on = False
    sea.say(origin(sea.now_us), sender=sea.own.station)
    for _ in range(20):
        sea.say(odometry(Course(), sea.now_us, frame_id=frame), sender=sea.own.station)
        sea.run(0.05)
    assert not sea.condition("own_fresh")
    assert sea.counter("mavlink_bad_frame") == 20
    said = texts(sea.ticks)
    assert any("ODOMETRY" in text and "frame" in text for text in said)
    assert len(said) <= 3, "said once in a while, not at every message"


@pytest.mark.parametrize(
    ("frame", "child"), [(0, 12), (13, 12), (16, 12), (255, 12), (1, 0), (1, 13), (1, 255)]
)
def test_a_frame_that_is_not_legal_is_refused(sea: Sea, frame: int, child: int) -> None:
    sea.own.on = False
    message = odometry(Course(), sea.now_us, frame_id=frame, child_frame_id=child)
    sea.say(message, sender=sea.own.station)
    sea.step()
    assert not sea.condition("own_fresh") and sea.refused("mavlink") == 1
