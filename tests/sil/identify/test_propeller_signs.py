# SPDX-License-Identifier: MIT
"""Propellers that are inverted or swapped are found before any fit."""

from dataclasses import replace

import numpy as np
import pytest

from sil.identify import propeller_signs
from sil.identify.voyage_log import BadLogError
from tests.sil.identify.sailed import levels, sail

BOTH = (False, True)


@pytest.mark.parametrize("swapped", BOTH)
@pytest.mark.parametrize("stbd", BOTH)
@pytest.mark.parametrize("port", BOTH)
def test_every_wiring_is_recognised_and_mended(port: bool, stbd: bool, swapped: bool) -> None:
    rng = np.random.default_rng(1)
    right = sail(levels(rng, 120.0), rng)
    columns = right.commands[:, ::-1] if swapped else right.commands
    signs = np.array([-1.0 if port else 1.0, -1.0 if stbd else 1.0])
    log = replace(right, commands=columns * signs)
    wiring = propeller_signs.find([log])
    assert (wiring.port_inverted, wiring.stbd_inverted, wiring.swapped) == (port, stbd, swapped)
    assert np.array_equal(propeller_signs.mended(log, wiring).commands, right.commands)


def test_a_gap_in_a_log_costs_only_the_seconds_in_it() -> None:
    rng = np.random.default_rng(5)
    log = sail(levels(rng, 120.0), rng)
    motion = log.motion.copy()
    motion[100:107] = np.nan
    whole, broken = (propeller_signs.find([replace(log, motion=m)]) for m in (log.motion, motion))
    assert broken.right
    assert broken.surge == pytest.approx(whole.surge, rel=0.1)


def test_commands_of_another_boat_are_refused() -> None:
    rng = np.random.default_rng(2)
    log = sail(levels(rng, 120.0), rng)
    foreign = replace(log, commands=levels(np.random.default_rng(3), 130.0)[: len(log.motion)])
    with pytest.raises(BadLogError, match="does not answer its propellers"):
        propeller_signs.find([foreign])


@pytest.mark.parametrize("trim", [0.0, 0.2])
@pytest.mark.parametrize("steady", [False, True])
def test_a_log_of_straights_alone_is_told_to_need_turns(trim: float, *, steady: bool) -> None:
    rng = np.random.default_rng(6)
    ahead = levels(rng, 120.0).mean(axis=1)
    steered = rng.normal(0.0, 0.01, (len(ahead), 2))  # to keep the course
    commands = np.full((len(ahead), 2), 0.5) if steady else ahead[:, None] + steered
    with pytest.raises(BadLogError, match="hardly changes"):
        propeller_signs.find([sail(commands + np.array([trim, 0.0]), rng)])


def test_small_turns_that_the_boat_answers_are_enough() -> None:
    rng = np.random.default_rng(7)
    ahead = 1.3 * np.clip(levels(rng, 400.0).mean(axis=1), -0.7, 0.7)
    turn = 0.03 * np.sign(np.sin(np.arange(len(ahead)) / 10.0))
    commands = np.column_stack([ahead + turn, ahead - turn])
    assert np.std(2.0 * turn) < 0.1 * np.std(2.0 * ahead)
    assert propeller_signs.find([sail(commands, rng)]).right


def test_a_sum_in_one_column_is_refused() -> None:
    rng = np.random.default_rng(4)
    log = sail(levels(rng, 120.0), rng)
    turn = log.commands[:, 0] - log.commands[:, 1]
    total = log.commands.sum(axis=1)
    odd = replace(log, commands=np.column_stack([total + turn, total / 2.0 + turn]) / 4.0)
    with pytest.raises(BadLogError, match="to the same side"):
        propeller_signs.find([odd])
