# SPDX-License-Identifier: MIT
"""The start of runs: an operator arms the boats and sets FORMATION while the hulls are held."""

from collections import defaultdict

import flotilla

from sil.lockstep.batch import Batch
from sil.wire.operator import Operator, start_requests

_WARM_UP_S = 2
_PATIENCE_S = 30
_RETRY_S = 1

_DISARMED, _HOLD, _IN_FORMATION = (
    flotilla.STATES.index(name) for name in ("DISARMED", "HOLD", "FORMATION")
)


class RunError(RuntimeError):
    """A run ended without figures; the text gives the reason."""


class StartError(RunError):
    """Boats could not be armed or put into FORMATION; the text names them and their reasons."""


def start(batch: Batch) -> list[int | StartError]:
    """Arm all boats and put them into FORMATION; for each run the time of success, us, or an error.

    Every run receives commands at the same times, independent of the others, until all are ready.
    """
    ready: dict[int, int | StartError] = {}
    runs = range(len(batch.scenarios))
    operators: defaultdict[int, Operator] = defaultdict(Operator)
    last_us = round(1e6 * (_PATIENCE_S - _RETRY_S))
    for t_us in range(0, round(1e6 * _PATIENCE_S), batch.h_us):
        pending = [run for run in runs if run not in ready]
        if t_us >= 1e6 * _WARM_UP_S and t_us % round(1e6 * _RETRY_S) < batch.h_us:
            for run in pending:
                _ask(batch, run, t_us)
        batch.tick(t_us)
        formed = (batch.states == _IN_FORMATION).all(axis=1)
        ready.update({run: t_us for run in pending if formed[run]})
        if len(ready) == len(runs):
            break
        if t_us >= last_us:
            _listen(batch, pending, operators)
    ready.update({run: _refusal(batch, run, operators) for run in runs if run not in ready})
    return [ready[run] for run in runs]


def _ask(batch: Batch, run: int, t_us: int) -> None:
    states = batch.states[run].tolist()
    for agent, state in zip(batch.agents(run), states, strict=True):
        slow_Hz = batch.fleet.parameters(agent)["SR_SLOW"]
        for request in start_requests(slow_Hz, _DISARMED not in states, state == _HOLD):
            batch.fleet.command([agent], t_us, *request)


def _listen(batch: Batch, runs: list[int], operators: dict[int, Operator]) -> None:
    for run in runs:
        for agent in batch.agents(run):
            operators[agent].on_mavlink(batch.fleet.sent(agent))


def _refusal(batch: Batch, run: int, operators: dict[int, Operator]) -> StartError:
    words = []
    boats = zip(batch.agents(run), batch.states[run].tolist(), strict=True)
    for boat, (agent, state) in enumerate(boats, start=1):
        if state != _IN_FORMATION:
            text = next(iter(operators[agent].text.values()), "no STATUSTEXT received")
            words.append(f"boat {boat}: {text}")
    return StartError(f"not in FORMATION after {_PATIENCE_S:g} s: {'; '.join(words)}")
