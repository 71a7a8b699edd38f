# SPDX-License-Identifier: MIT
"""A BlueBoat changes sides, close astern of a WAM-V of its fleet."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from sil.lockstep.batch import Batch
from sil.lockstep.world import all_sailed, sail
from sil.plant.hull import Array
from sil.scenario import presets, scenario
from sil.wire.fleet_table import Member, table_message
from tests.loop.presets import alike

LEADER, RADIO = 100, 1
LENGTH_M, BEAM_M = {"wamv": 4.9, "blueboat": 1.2}, {"wamv": 2.4, "blueboat": 0.8}
HULLS = ("wamv", "blueboat")
WAMV_M, FROM_M, TO_M = (-20.0, 0.0), (-22.5, -18.0), (-22.5, 18.0)
FLEET = """
duration_s = 1.0
[leader.navigation]
rate_hz = 100.0
[[leader.input]]
surge_N = 0.0
[formation]
shape = "line"
boats = 2
spacing_m = 18.0
turns = false
[link]
everyone = true
[boat.1]
hull = "wamv"
[boat.2]
hull = "blueboat"
"""
FORMS_S, CHANGES_S, MOVE_S = 5.0, 60.0, 60.0


class Observer:
    """Sends a table, then one in which the BlueBoat has its place on the other side."""

    def __init__(self, *, lengths: bool) -> None:
        self.eta: list[Array] = []
        self._lengths = lengths

    def __call__(self, batch: Batch, _: Sequence[int], k: int, t_us: int) -> None:
        rows = list(batch.agents(0))
        for epoch, at_s, place_m in ((1, FORMS_S, FROM_M), (2, CHANGES_S, TO_M)):
            if k == round(1e6 * at_s / batch.h_us):
                batch.fleet.hear(rows[0], self._table(epoch, place_m), t_us, RADIO)
        if k % 10 == 0:
            self.eta.append(batch.bodies.eta[rows].copy())

    def _table(self, epoch: int, place_m: tuple[float, float]) -> bytes:
        length_m = [LENGTH_M[hull] if self._lengths else 0.0 for hull in HULLS]
        members = [
            Member(LEADER, 0, (0.0, 0.0), 0.0, only_leads=True),
            Member(1, LEADER, WAMV_M, length_m[0]),
            Member(2, LEADER, place_m, length_m[1]),
        ]
        return table_message(epoch, members, in_s=1.0, move_s=MOVE_S * (epoch > 1))


def outlines_m(a: Array, b: Array) -> Array:
    """Distance of the outlines of a WAM-V and a BlueBoat, taken as rectangles; (times, 3)."""
    return np.minimum(_to_outline_m(a, b, *HULLS), _to_outline_m(b, a, *reversed(HULLS)))


def _to_outline_m(eta: Array, other: Array, own: str, others: str) -> Array:
    """Distance of the points of the other hull's outline from the own rectangle."""
    t = np.linspace(-1.0, 1.0, 41)
    one = np.ones_like(t)
    edge = np.concatenate([np.stack(p, -1) for p in ((t, one), (t, -one), (one, t), (-one, t))])
    points = other[:, None, :2] + _turned(
        edge * (LENGTH_M[others] / 2, BEAM_M[others] / 2), other[:, None, 2]
    )
    seen = np.abs(_turned(points - eta[:, None, :2], -eta[:, None, 2]))
    beyond = np.maximum(seen - (LENGTH_M[own] / 2, BEAM_M[own] / 2), 0.0)
    nearest: Array = np.hypot(beyond[..., 0], beyond[..., 1]).min(axis=1)
    return nearest


def _turned(v: Array, psi: Array) -> Array:
    c, s = np.cos(psi), np.sin(psi)
    return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1]], -1)


def sailed(folder: Path, *, lengths: bool) -> Array:
    """(times, boats, 3)."""
    file = folder / "mixed.toml"
    file.write_text(FLEET)
    curve = [change for change in alike("wamv") if "surge_N" in change]
    one = scenario.load(file, [*curve, f"duration_s={CHANGES_S + MOVE_S + 90.0}"])
    observer = Observer(lengths=lengths)
    all_sailed(sail([one], {}, keep_s=1.0, watch=observer))
    return np.array(observer.eta)


def test_the_hulls_have_these_lengths() -> None:
    for hull, length_m in LENGTH_M.items():
        assert presets.load(hull).vessel.length_m == length_m


def test_a_small_boat_keeps_clear_of_a_great_ones_outline(tmp_path: Path) -> None:
    eta = sailed(tmp_path, lengths=True)
    apart = outlines_m(eta[:, 0], eta[:, 1])
    print(f"least distance of the outlines: {apart.min():.2f} m")
    assert apart.min() > 0.3
    off = eta[-1, 1, :2] - eta[-1, 0, :2]
    assert off == pytest.approx(np.subtract(TO_M, WAMV_M), abs=0.5)
