# SPDX-License-Identifier: MIT
"""Applies the `[[fault]]` entries of runs that are sailed together, each at its tick."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sil.lockstep.batch import Batch
from sil.scenario.agents import clocks_of
from sil.scenario.fault_errors import is_escs
from sil.scenario.scenario import Scenario
from sil.scenario.sections import Fault
from sil.scenario.streams import Stream, generator


def check(scenario: Scenario) -> None:
    """ValueError if a fault would turn a clock back to before its start."""
    clocks = clocks_of(scenario)
    for number, fault in enumerate(scenario.fault, start=1):
        if fault.kind in ("clock", "own_clock"):
            shown_s = 1e-6 * clocks[fault.agent].at(round(1e6 * fault.at_s)) + fault.value
            if shown_s < 0.0:
                raise ValueError(
                    f"fault {number}: agent {fault.agent}'s clock would be turned back to before "
                    f"its start, by {-shown_s:.0f} s; raise clocks.offset_s to start it earlier"
                )


@dataclass(frozen=True)
class _Event:
    tick: int
    run: int
    fault: Fault
    begins: bool
    seed: int


class Timeline:
    """The faults of the runs of `batch`, by tick after the release.

    A replay fault listens from `value` seconds before its time on. Events at or before the release
    take place at the first tick after it. The shortest fault lasts one tick.
    """

    def __init__(self, batch: Batch) -> None:
        self._batch = batch
        events = [
            event
            for run, scenario in enumerate(batch.scenarios)
            for event in _events(run, scenario, 1e-6 * batch.h_us)
        ]
        # At equal ticks, faults end before others begin.
        self._events = deque(sorted(events, key=lambda event: (event.tick, event.begins)))

    def apply(self, tick: int, t_us: int) -> None:
        """Apply the events due before tick `tick`, at `t_us`."""
        while self._events and self._events[0].tick <= tick:
            event = self._events.popleft()
            act(self._batch, event.run, event.fault, event.begins, t_us, event.seed)


def act(batch: Batch, run: int, fault: Fault, begins: bool, t_us: int, seed: int = 0) -> None:
    """Begin or end a fault of a run at `t_us`."""
    row = batch.row(run, fault.agent)
    if fault.kind == "own_noisy":
        batch.sensors.worse[row] = fault.value if begins else 1.0
        return
    if fault.kind == "gcs_silent":
        (batch.without_gcs.add if begins else batch.without_gcs.discard)(row)
        return
    esc = fault.esc if is_escs(fault) and fault.esc != "both" else None
    if begins:
        named: dict[str, Any] = {"value": fault.value, "esc": esc, "seed": seed}
        batch.fleet.set_fault(row, fault.kind, t_us, **named)
    else:
        batch.fleet.clear_fault(row, fault.kind, t_us, esc=esc)


def _events(run: int, scenario: Scenario, h_s: float) -> Sequence[_Event]:
    rng = generator(scenario.seed, Stream.FAULTS)
    events = []
    for fault in scenario.fault:
        seed = int(rng.integers(1 << 64, dtype=np.uint64))
        at_s = fault.at_s - (fault.value if fault.kind == "replay" else 0.0)
        begin = max(1, round(at_s / h_s))
        events.append(_Event(begin, run, fault, True, seed))
        if fault.for_s is not None:
            over = max(begin + 1, round((fault.at_s + fault.for_s) / h_s))
            events.append(_Event(over, run, fault, False, seed))
    return events
