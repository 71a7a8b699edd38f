# SPDX-License-Identifier: MIT
"""The effect of measurement noise on the thrusts, against the law's terms and noisy fixes."""

import flotilla
import numpy as np
import pytest

from sil.certificate import monodromy
from sil.certificate.loop import BODY, leader_rows
from sil.certificate.noise import noise_gains
from tests.sil.certificate.made_up import SINE, boat


def test_velocity_and_yaw_rate_reach_the_thrusts_by_their_gains() -> None:
    changes = [{"LAW_KDU": 10.0, "LAW_KDR": 10.0}, {"LAW_KDU": 20.0, "LAW_KDR": 40.0}]
    found = []
    for changed in changes:
        setup = boat(SINE, changed=changed)
        found.append(noise_gains(setup, monodromy.on_slot(setup, monodromy.instants(setup, 1))))
    first, second = found
    # half of X a propeller; N over both of them and their arms of 0.25 m
    assert second["yaw rate"] - first["yaw rate"] == pytest.approx(30.0 / 0.5, rel=0.01)
    assert 4.0 < second["velocity"] - first["velocity"] < 5.0 + 0.1


def test_noise_gains_predict_the_thrust_noise_of_noisy_fixes() -> None:
    setup = boat(law="product")
    points = monodromy.on_slot(setup, monodromy.instants(setup, 6, windows=1))
    sigma, rng = 1e-4, np.random.default_rng(1)
    square, count = 0.0, 300
    rows = leader_rows(setup.leader, setup.h_s * points.ticks.astype(np.float64))
    for row, state in zip(rows.tolist(), points.states, strict=True):
        thrusts = np.empty((count, 2))
        for i, noise in enumerate(sigma * rng.standard_normal((count, 6))):
            helm = flotilla.Helm(dict(setup.parameters))
            helm.state = state[BODY:].tolist()
            helm.fix(*(state[:6] + noise).tolist(), 0.0, setup.h_s)
            told = helm.step(row, setup.h_s)["thrust_N"]
            thrusts[i] = told["port"], told["stbd"]
        square += float(thrusts.var(axis=0).mean()) / len(rows)
    said = sum(gain**2 for gain in noise_gains(setup, points).values())
    assert np.sqrt(square) == pytest.approx(sigma * np.sqrt(said), rel=0.05)
