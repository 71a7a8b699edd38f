# SPDX-License-Identifier: MIT
"""The start of runs: an operator arms the boats and sets FORMATION while the hulls are held."""

from collections import defaultdict

import flotilla
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.batch import Batch
from sil.wire.heartbeat import FORMATION, HOLD
from sil.wire.mavlink_messages import ESC_INFO, ESC_STATUS
from sil.wire.operator import Operator

_WARM_UP_S = 2
_PATIENCE_S = 30
_RETRY_S = 1

_DISARMED, _HOLD, _IN_FORMATION = (
    flotilla.STATES.index(name) for name in ("DISARMED", "HOLD", "FORMATION")
)
_CUSTOM_MODE = float(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)


class RunError(RuntimeError):
    """A run ended without figures; the text gives the reason."""


class StartError(RunError):
    """Boats could not be armed or put into FORMATION; the text names them and their reasons."""


def esc_intervals(slow_Hz: float) -> list[tuple[float, float]]:
    """Message ids and intervals, us, of ESC_STATUS and ESC_INFO, which boats send on request."""
    if slow_Hz <= 0:
        return []
    return [(float(ESC_STATUS), 1e6 / slow_Hz), (float(ESC_INFO), 1e6 * max(5, 1 / slow_Hz))]


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
    command = batch.fleet.command
    for agent, state in zip(batch.agents(run), states, strict=True):
        for interval in esc_intervals(batch.fleet.parameters(agent)["SR_SLOW"]):
            command([agent], t_us, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, interval)
        command([agent], t_us, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (1.0,))
        if _DISARMED not in states:
            # All boats in one tick; a boat that is not in HOLD goes there first.
            modes = (FORMATION,) if state == _HOLD else (HOLD, FORMATION)
            for mode in modes:
                command([agent], t_us, mavlink.MAV_CMD_DO_SET_MODE, (_CUSTOM_MODE, float(mode)))


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
