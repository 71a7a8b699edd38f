# SPDX-License-Identifier: MIT
"""A fleet that boat 1 leads by its plan, along four routes: how well all sail it.

    python -m tests.loop.leading [--weather still|sea] [--position NOISE_M DRIFT_M]

Boat 1 gets its plan by MAVLink and sails it in AUTO; three boats follow in a diamond. Its
hull resembles a BlueBoat's (1.2 m, 20 N a propeller, one of them 15 % weak), which its firmware
does not know. Truth is compared with the rounded plan, made by the same planner alone.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass

import flotilla
import numpy as np
from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console
from rich.progress import Progress

from sil.lockstep.batch import Batch
from sil.lockstep.policies import violations
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.route import ACCELERATION_MPS2, YAW_ACCELERATION_RADPS2
from sil.scenario.wiring import ORIGIN
from sil.wire.geodesy import LocalFrame
from sil.wire.operator import ARM, SYSTEM, mode_request

SPACING_M, RADIUS_M, HULL_M = 3.0, 1.5, 1.2
AUTO, FORMATION = 10, 6
#: What half of the thrust of one propeller turns this hull with: arm × force / drag.
LEAST_YAW_RATE_RADPS = 0.29 * 10.0 / 9.0
#: Places north and east of the leader.
SLOTS = ((0.0, 0.0), (-SPACING_M, -SPACING_M), (-SPACING_M, SPACING_M), (-2 * SPACING_M, 0.0))

LEARNS = 2000  # ticks

Place = tuple[float, float]


def sine() -> list[Place]:
    """132 m: two waves of 3 m."""
    return [(x, 3.0 * math.sin(2 * math.pi * x / 60.0)) for x in np.arange(6.0, 121.0, 6.0)]


def square() -> list[Place]:
    """Three sides and a half of 50 m."""
    return [(50.0, 0.0), (50.0, 50.0), (0.0, 50.0), (0.0, 25.5)]


def lawnmower() -> list[Place]:
    """Four tracks of 50 m, 10 m apart."""
    return [(50, 0), (50, 10), (0, 10), (0, 20), (50, 20), (50, 30), (0, 30)]


def sharp() -> list[Place]:
    """Turns of 120° and more."""
    return [(40, 0), (10, 17), (50, 25), (20, 42), (40, 52)]


WELL = ("AUTO", *["FORMATION"] * 3)

#: Waypoints, and the speed in m/s.
ROUTES = {
    "sine": (sine(), 0.5),
    "square": (square(), 0.5),
    "lawnmower": (lawnmower(), 0.5),
    "sharp angles": (sharp(), 0.7),
}
WEATHERS = {
    "still": ["water.current_mps=[0.07, 0.07]"],
    "sea": [
        "water.current_mps=[0.21, 0.21]",
        "wind.mean_mps=[-5.6, 5.6]",
        "wind.gust_mps=1.0",
        "waves.height_m=0.1",
        "waves.course_rad=2.36",
    ],
}
BOAT = [
    "law=product",
    "vessel.m11=24",
    "vessel.m22=38",
    "vessel.m33=5.5",
    "vessel.d11=9",
    "vessel.d11_quadratic=8",
    "vessel.d22=70",
    "vessel.d33=9",
    "vessel.length_m=1.2",
    "vessel.draft_m=0.15",
    "vessel.hull_y_m=0.35",
    "vessel.frontal_m2=0.1",
    "vessel.lateral_m2=0.2",
    "vessel.wind_x=0.7",
    "vessel.wind_y=0.8",
    "vessel.wind_n=0.1",
    "vessel.drift_x_m=0.03",
    "vessel.drift_y_m=0.1",
    "propellers.arm_m=0.29",
    "propellers.forward_max_N=20",
    "propellers.reverse_max_N=20",
    "propellers.lag_s=0.1",
    "propellers.stbd_gain=0.85",
    "clocks.offset_s=3600",
    "clocks.drift_ppm=20",
    "link.delay_s=0.1",
    "link.loss=0.05",
    "navigation.rate_hz=20",
    "navigation.heading_noise_rad=0.0087",
    "navigation.velocity_noise_mps=0.02",
    "navigation.yaw_rate_noise_radps=0.0035",
]


#: The firmware's parameters of that boat.
PRODUCT = {
    "SR_STATE": 10,
    "VES_M11": 24,
    "VES_M22": 38,
    "VES_M33": 5.5,
    "VES_D11": 13,  # at 0.5 m/s
    "VES_D22": 70,
    "VES_D33": 9,
    # As in `sea`: (d11 + k_du) / m11 = 1.5 rad/s, (d33 + k_dr) / m33 = 3.9 rad/s.
    "LAW_KDU": 25,
    "LAW_KDR": 12,
    "THR_SLEW": 5,
    "THR_ARM": 0.29,
    "THR_FWD_MAX": 20,
    "THR_REV_MAX": 20,
    "FS_SEP_M": -1,
    "BOAT_LEN": HULL_M,
    "WP_RADIUS": RADIUS_M,
}


@dataclass(frozen=True)
class Sailed:
    """One route: metres, and shares.

    `mean_m`, `worst_m`: boat 1's distance from the rounded plan; `corner_m`: the worst within 5 m
    of a waypoint, without the first 20 s, in which the boat learns the current and its thrust;
    `cut_m`: greatest distance of the rounded plan from a waypoint; `speed`: the planned time over
    the time that it took; `rms_m`: the worst follower's distance from its slot; `closest`: least
    distance of two boats, as a share of that of their slots.
    """

    mean_m: float
    worst_m: float
    corner_m: float
    cut_m: float
    speed: float
    rms_m: float
    closest: float
    states: tuple[str, ...]


def scenario_of(weather: str, noise_m: float, drift_m: float) -> scenario.Scenario:
    """Four boats at rest in their slots, heading north."""
    places = []
    for boat, (north, east) in enumerate(SLOTS, start=1):
        places += [
            f"boat.{boat}.eta=[{north}, {east}, 0]",
            f"boat.{boat}.offset_m=[{north}, {east}]",
        ]
        if boat > 1:
            places.append(f"boat.{boat}.follows=1")
    errors = [
        f"navigation.position_noise_m={noise_m}",
        f"navigation.position_drift_m={drift_m}",
    ]
    given = [f"parameters.{name}={float(value)}" for name, value in PRODUCT.items()]
    return scenario.load("diamond", [*BOAT, *WEATHERS[weather], *places, *errors, *given])


class Shore:
    """The ground station of all runs."""

    def __init__(self, batch: Batch) -> None:
        self._batch = batch
        self._encoder = mavlink.MAVLink(None, SYSTEM, 190)
        self._decoder = mavlink.MAVLink(None)
        self._decoder.robust_parsing = True
        self._frame = LocalFrame(*ORIGIN[:2], ORIGIN[2] * 1e-3)

    def send_plan(self, agent: int, plan: Sequence[Place], speed_mps: float, t_us: int) -> int:
        """Send a plan to a boat; the time afterwards."""
        system = int(self._batch.fleet.parameters(agent)["MAV_SYSID"])
        boat = (system, 1)
        rows = [(178, (1.0, speed_mps, -1.0, 0.0), 0, 0)]
        for north, east in plan:
            at = self._frame.geodetic(north, east, 0.0)
            rows.append((16, (0.0, RADIUS_M, 0.0, math.nan), at.latitude, at.longitude))
        self._say(agent, mavlink.MAVLink_mission_count_message(*boat, len(rows), 0), t_us)
        while True:
            t_us += self._batch.h_us
            self._batch.tick(t_us)
            for m in self._decoder.parse_buffer(self._batch.fleet.sent(agent)) or []:
                if m.get_type() == "MISSION_REQUEST_INT":
                    command, params, x, y = rows[m.seq]
                    item = mavlink.MAVLink_mission_item_int_message(
                        *boat, m.seq, 6, command, 0, 1, *params, x, y, 0.0, 0
                    )
                    self._say(agent, item, t_us)
                if m.get_type() == "MISSION_ACK":
                    assert m.type == mavlink.MAV_MISSION_ACCEPTED, m
                    return t_us

    def _say(self, agent: int, message: mavlink.MAVLink_message, t_us: int) -> None:
        self._batch.fleet.hear(agent, message.pack(self._encoder), t_us)


def reference(plan: Sequence[Place], speed_mps: float, ticks: int, h_s: float) -> Array:
    """The rounded plan's motion from the origin, as `flotilla.sail_route` has it."""
    points = np.zeros((len(plan) + 1, 5))
    points[1:, :2] = plan
    points[:, 2], points[:, 3] = speed_mps, RADIUS_M
    limits = (ACCELERATION_MPS2, LEAST_YAW_RATE_RADPS, YAW_ACCELERATION_RADPS2)
    motion: Array = flotilla.sail_route(points, *limits, 0.0, 0.0, h_s, ticks)
    return motion


def sail(
    names: Sequence[str], weather: str = "still", position: tuple[float, float] = (0.02, 0.03)
) -> dict[str, Sailed]:
    """Sail these routes together, one run each."""
    one = scenario_of(weather, *position)
    batch = Batch([one] * len(names), {})
    shore = Shore(batch)
    fleet, boats = batch.fleet, len(SLOTS)
    t_us = 0
    while t_us < 8_000_000:  # ages and clocks are known
        batch.tick(t_us)
        t_us += batch.h_us
    leaders = [batch.row(run, 1) for run in range(len(names))]
    for agent, name in zip(leaders, names, strict=True):
        t_us = shore.send_plan(agent, *ROUTES[name], t_us)
    fleet.command([a for run in range(len(names)) for a in batch.agents(run)], t_us, *ARM)
    for _ in range(100):
        t_us += batch.h_us
        batch.tick(t_us)
    followers = [a for run in range(len(names)) for a in list(batch.agents(run))[1:]]
    fleet.command(leaders, t_us, *mode_request(AUTO))
    fleet.command(followers, t_us, *mode_request(FORMATION))
    h_s = 1e-6 * batch.h_us
    plans = {name: reference(*ROUTES[name], round(900 / h_s), h_s) for name in names}
    end = max(
        int((plan[:, 9] >= len(ROUTES[name][0]) + 1).argmax()) for name, plan in plans.items()
    )
    ticks = end + round(15 / h_s)
    tau = np.zeros((3, 1, 2))
    eta = np.zeros((ticks, len(names), boats, 3))
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for k in progress.track(range(ticks)):
            eta[k] = batch.bodies.eta[len(names) :].reshape(len(names), boats, 3)
            t_us += batch.h_us
            batch.tick(t_us)
            batch.bodies.advance(batch.command, tau, h_s)
    assert not violations(batch), violations(batch)
    words = [[flotilla.STATES[state] for state in row] for row in batch.states.tolist()]
    return {
        name: judge(eta[:, run], plans[name], ROUTES[name][0], tuple(words[run]))
        for run, name in enumerate(names)
    }


def judge(eta: Array, plan: Array, points: Sequence[Place], states: tuple[str, ...]) -> Sailed:
    """Compare the boats' poses (T, 4, 3) with the rounded plan, both from the start on."""
    arrives = int((plan[:, 9] >= len(points) + 1).argmax())
    end = np.array(points[-1])
    near = np.hypot(*(eta[:, 0, :2] - end).T) < 0.5
    there = int(near.argmax()) if near.any() else len(eta)
    planned = int((np.hypot(*(plan[:arrives, :2] - end).T) < 0.5).argmax())
    track = plan[:arrives:5, :2]
    off = np.array([np.hypot(*(track - at).T).min() for at in eta[:there:10, 0, :2]])
    corners = np.array(points[:-1])
    at_corner = [
        k > LEARNS and np.hypot(*(corners - at).T).min() < 5.0
        for k, at in zip(range(0, there, 10), eta[:there:10, 0, :2], strict=True)
    ]
    cut = max(np.hypot(*(track - corner).T).min() for corner in corners)
    worst_rms = 0.0
    settled = np.arange(LEARNS, min(there, arrives), 10)
    # The boat turns to the first leg before the plan begins: the plan's clock is that much late.
    nearest = [5 * int(np.hypot(*(track - eta[k, 0, :2]).T).argmin()) for k in settled]
    late = round(float(np.median(settled - nearest)))
    for boat, slot in enumerate(SLOTS[1:], start=1):
        error = np.hypot(*(eta[settled, boat, :2] - plan[settled - late, :2] - slot).T)
        worst_rms = max(worst_rms, float(np.sqrt((error**2).mean())))
    apart = [
        np.hypot(*(eta[:, i, :2] - eta[:, j, :2]).T).min()
        for i in range(len(SLOTS))
        for j in range(i)
    ]
    least = SPACING_M * math.sqrt(2)
    return Sailed(
        float(off.mean()),
        float(off.max()),
        float(off[np.array(at_corner)].max()),
        float(cut),
        planned / there,
        worst_rms,
        float(min(apart)) / least,
        states,
    )


def main() -> None:
    """Sail all routes and print the rows of the page of measurements."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--weather", choices=WEATHERS, default="still")
    parser.add_argument("--position", nargs=2, type=float, default=(0.02, 0.03))
    given = parser.parse_args()
    print("| route | mean | worst | at corners | rounded by | speed | followers | closest |")
    for name, it in sail(list(ROUTES), given.weather, tuple(given.position)).items():
        lengths = (it.mean_m, it.worst_m, it.corner_m, it.cut_m)
        cells = [f"{cell:.2f}" for cell in (*lengths, it.speed, it.rms_m, it.closest)]
        wrong = [] if it.states == WELL else ["ended in " + ", ".join(it.states)]
        print("|", " | ".join([name, *cells, *wrong]), "|")


if __name__ == "__main__":
    main()
