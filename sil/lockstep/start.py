# SPDX-License-Identifier: MIT
"""The start of runs: an operator arms the boats and sets their modes while the hulls are held.

All boats go to FORMATION. A boat that leads receives its plan meanwhile, and goes to AUTO last.
"""

from collections import defaultdict

import flotilla
import numpy as np

from sil.lockstep.batch import Batch
from sil.scenario.told_plan import items_of
from sil.wire.heartbeat import AUTO, FORMATION, HOLD
from sil.wire.operator import Operator, mode_request, plan_upload, start_requests
from sil.wire.plan_upload import PlanUpload

_WARM_UP_S = 2
_PATIENCE_S = 30
_RETRY_S = 1
_RECALL_AFTER_S = 10  # after this time, boats that form up before others are put into HOLD again
_TOGETHER_S = 0.3  # any longer, and a boat would find that it does not respond to its thrust
_FORGETS_S = 3  # after this time, a boat has forgotten that it did not respond
_RADIO = 1  # link of a boat

_DISARMED, _HOLD, _IN_FORMATION, _IN_AUTO = (
    flotilla.STATES.index(name) for name in ("DISARMED", "HOLD", "FORMATION", "AUTO")
)


class RunError(RuntimeError):
    """A run ended without figures; the text gives the reason."""


class StartError(RunError):
    """Boats could not be armed or put into FORMATION; the text names them and the reasons."""


def start(batch: Batch) -> list[int | StartError]:
    """Arm all boats, set their modes; return each run's time of success, us, or its error.

    Every run receives its commands independently of the others, until all are ready.
    """
    ready: dict[int, int | StartError] = {}
    runs = range(len(batch.scenarios))
    operators: defaultdict[int, Operator] = defaultdict(Operator)
    plans = _Plans(batch)
    again_us: defaultdict[int, int] = defaultdict(int)
    last_us = round(1e6 * (_PATIENCE_S - _RETRY_S))
    for t_us in range(0, round(1e6 * _PATIENCE_S), batch.h_us):
        pending = [run for run in runs if run not in ready]
        if t_us >= 1e6 * _WARM_UP_S:
            plans.say(t_us)
            since_us = t_us % round(1e6 * _RETRY_S)
            if since_us < batch.h_us:
                for run in pending:
                    _ask(batch, run, plans, t_us, t_us >= min(again_us[run], last_us))
            elif (
                1e6 * _RECALL_AFTER_S <= t_us < last_us
                and 0 <= since_us - round(1e6 * _TOGETHER_S) < batch.h_us
            ):
                for run in pending:
                    if _recall(batch, run, plans, t_us):
                        again_us[run] = t_us + round(1e6 * _FORGETS_S)
        batch.tick(t_us)
        plans.listen(t_us)
        formed = (batch.states == plans.wanted).all(axis=1)
        ready.update({run: t_us for run in pending if formed[run]})
        if len(ready) == len(runs):
            break
        if t_us >= last_us:
            _listen(batch, pending, operators)
    ready.update({run: _refusal(batch, run, operators, plans) for run in runs if run not in ready})
    return [ready[run] for run in runs]


class _Plans:
    """The plans of runs in which a boat leads. `wanted` (R, N): states in which all are ready."""

    def __init__(self, batch: Batch) -> None:
        self._batch = batch
        self.wanted = np.full((len(batch.scenarios), batch.boats), _IN_FORMATION, np.uint8)
        self.uploads: dict[int, PlanUpload] = {}
        for run, one in enumerate(batch.scenarios):
            if one.leader.boat is not None:
                self.wanted[run, one.leader.boat - 1] = _IN_AUTO
                self.uploads[run] = plan_upload(one.leader.boat, items_of(one.leader))

    def say(self, t_us: int) -> None:
        for run, upload in self.uploads.items():
            if data := upload.say(t_us):
                self._batch.fleet.hear(self._batch.leading(run), data, t_us, _RADIO)

    def listen(self, t_us: int) -> None:
        for run, upload in self.uploads.items():
            upload.on_mavlink(self._batch.fleet.sent(self._batch.leading(run)), t_us)

    def mode_of(self, run: int, boat: int, states: list[int]) -> int:
        """The mode to request of a boat, from 0: AUTO once it has its plan and all follow."""
        wanted = self.wanted[run].tolist()
        if wanted[boat] == _IN_FORMATION:
            return FORMATION
        others = [k for k in range(len(states)) if k != boat]
        formed = all(states[k] == wanted[k] for k in others)
        return AUTO if formed and self.uploads[run].done else HOLD


def _ask(batch: Batch, run: int, plans: _Plans, t_us: int, modes: bool) -> None:
    """Ask all boats to arm and, with `modes`, to enter their modes."""
    states = batch.states[run].tolist()
    for boat, (agent, state) in enumerate(zip(batch.agents(run), states, strict=True)):
        slow_Hz = batch.fleet.parameters(agent)["SR_SLOW"]
        mode = plans.mode_of(run, boat, states)
        for request in start_requests(
            slow_Hz, modes and _DISARMED not in states, state == _HOLD, mode
        ):
            batch.fleet.command([agent], t_us, *request)


def _recall(batch: Batch, run: int, plans: _Plans, t_us: int) -> bool:
    """Put boats that formed up before the others into HOLD; False if there were none.

    Otherwise they would push against the force that holds the hulls.
    """
    followers = plans.wanted[run] == _IN_FORMATION
    formed = batch.states[run] == _IN_FORMATION
    if formed[followers].all():
        return False
    for boat in np.flatnonzero(formed):
        batch.fleet.command([batch.agents(run)[boat]], t_us, *mode_request(HOLD))
    return bool(formed.any())


def _listen(batch: Batch, runs: list[int], operators: dict[int, Operator]) -> None:
    for run in runs:
        for agent in batch.agents(run):
            operators[agent].on_mavlink(batch.fleet.sent(agent))


def _refusal(batch: Batch, run: int, operators: dict[int, Operator], plans: _Plans) -> StartError:
    words = []
    boats = zip(batch.agents(run), batch.states[run].tolist(), strict=True)
    for boat, (agent, state) in enumerate(boats):
        if state != plans.wanted[run, boat]:
            text = next(iter(operators[agent].text.values()), "no STATUSTEXT received")
            words.append(f"boat {boat + 1}: {text}")
    if run in plans.uploads and plans.uploads[run].fault:
        words.append(f"the plan: {plans.uploads[run].fault}")
    return StartError(f"not in the wanted mode after {_PATIENCE_S:g} s: {'; '.join(words)}")
