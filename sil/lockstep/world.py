# SPDX-License-Identifier: MIT
"""The lockstep world: a virtual clock, hulls, and all vessels ticked in turn in one thread.

One run or many use the same code and give the same bits: see `sil.lockstep.batch`.
"""

from collections.abc import Callable, Hashable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import flotilla

from sil.lockstep import timeline
from sil.lockstep.batch import Batch
from sil.lockstep.policies import violations
from sil.lockstep.recording import MOST_BOATS, Recorder
from sil.lockstep.start import RunError, StartError, start
from sil.lockstep.trace import Tracer
from sil.plant.hull import Array
from sil.scenario.agents import parameters_of
from sil.scenario.scenario import Scenario
from sil.scenario.virtual_leaders import VirtualLeaders

Progress = Callable[[float], None]
# Called after each tick from the release on, before the hulls move: the batch, the index of each
# run's scenario, number of the tick, time in us.
Watch = Callable[[Batch, Sequence[int], int, int], None]


@dataclass(frozen=True)
class Run:
    """The result of a run: `trace` as in trace.npz, seconds in each state, digest."""

    trace: dict[str, Array]
    states: list[dict[str, float]]
    digest: str | None


class World:
    """One scenario, ready to be sailed.

    `param_overrides` apply to every boat and override the scenario. ValueError, naming the
    parameter, if the firmware refuses one.
    """

    def __init__(self, scenario: Scenario, param_overrides: dict[str, float]) -> None:
        check(scenario, param_overrides)
        self._scenario = scenario
        self._overrides = param_overrides

    def run(self, recording: Path, progress: Progress) -> Run:
        """Sail the scenario; writes `recording`, calls `progress` with the share done.

        A fleet too large for a recording has none, and no digest. StartError if the boats cannot
        be put into FORMATION; PolicyViolationError if one breaks a rule, with the recording up to
        then.
        """
        scenarios = [self._scenario]
        room = len(self._scenario.boat) <= MOST_BOATS
        record = recording if room else None
        (run,) = all_sailed(sail(scenarios, self._overrides, record=record, progress=progress))
        return run


def check(scenario: Scenario, param_overrides: dict[str, float]) -> None:
    """ValueError if a boat's firmware refuses a parameter or a fault is impossible."""
    for own in parameters_of(scenario, param_overrides):
        flotilla.Boat(own, links=2, scalar=scenario.scalar)
    timeline.check(scenario)


def sail(
    scenarios: Sequence[Scenario],
    param_overrides: dict[str, float],
    *,
    record: Path | None = None,
    digest: bool = False,
    keep_s: float | None = None,
    progress: Progress = lambda _: None,
    watch: Watch | None = None,
) -> list[Run | RunError]:
    """Sail scenarios together; return for each, in order, a run or the error that prevented it.

    A run is the same, bit for bit, whichever scenarios it is sailed with. `record`: file for the
    recording of a single scenario; `digest`: compute digests also without a recording. `keep_s`:
    interval of the traces' samples; None: every tick, which figures of the whole run need.
    `progress` is called with the share done, `watch` after each tick. A parameter that the firmware
    refuses is a StartError; a broken rule is a PolicyViolationError, regardless of other events in
    the run. ValueError if there are too many boats for a recording.
    """
    if record is not None and len(scenarios) != 1:
        raise ValueError("only a single run can be recorded")
    if (record or digest) and any(len(one.boat) > MOST_BOATS for one in scenarios):
        raise ValueError(f"a recording holds at most {MOST_BOATS} boats")
    results: dict[int, Run | RunError] = {}
    alike: dict[Hashable, list[int]] = {}
    for i, scenario in enumerate(scenarios):
        try:
            check(scenario, param_overrides)
        except ValueError as error:
            results[i] = StartError(str(error))
        else:
            alike.setdefault(_shape(scenario), []).append(i)
    order = _Options(param_overrides, record, record is not None or digest, keep_s, progress, watch)
    for members in alike.values():
        order.sail(members, scenarios, results)
    return [results[i] for i in range(len(scenarios))]


def all_sailed(results: Iterable[Run | RunError]) -> list[Run]:
    """The runs that `sail` returned; raises its first error, if any."""
    runs = []
    for result in results:
        if isinstance(result, RunError):
            raise result
        runs.append(result)
    return runs


def _shape(scenario: Scenario) -> Hashable:
    """The properties that runs must share to be sailed as one batch."""
    follows = tuple(boat.follows for boat in scenario.boat)
    times = scenario.duration_s, scenario.rate_hz, scenario.white_noise.sample_s
    return follows, times, scenario.scalar, scenario.leader.boat


@dataclass(frozen=True)
class _Options:
    """The options of `sail`."""

    param_overrides: dict[str, float]
    record: Path | None
    digest: bool
    keep_s: float | None
    progress: Progress
    watch: Watch | None

    def sail(
        self,
        members: Sequence[int],
        scenarios: Sequence[Scenario],
        results: dict[int, Run | RunError],
    ) -> None:
        """Sail the scenarios with the indices `members`, which are of one shape."""
        with ExitStack() as opened:
            chosen = [scenarios[i] for i in members]
            batch = Batch(chosen, self.param_overrides, record=self.digest)
            if self.digest:
                for run in range(len(members)):
                    recorder = Recorder(self.record, batch.header(run))
                    batch.recorders.append(opened.enter_context(recorder))
            ready = start(batch)
            if isinstance(ready[0], int) and len(set(ready)) == 1:
                done = len(results) / len(scenarios)
                share = len(members) / len(scenarios)
                runs = self._to_the_end(batch, members, ready[0], done, share)
                results.update(zip(members, runs, strict=True))
                return
            broken = violations(batch, self.record)
            if self.record is not None and broken:
                self._finish(batch)
        for run, (i, t) in enumerate(zip(members, ready, strict=True)):
            if isinstance(t, StartError):
                results[i] = broken.get(run, t)
        # Runs that were ready at the same time sail together, again from the start.
        for t_us in sorted({t for t in ready if isinstance(t, int)}):
            together = [i for i, t in zip(members, ready, strict=True) if t == t_us]
            self.sail(together, scenarios, results)

    def _to_the_end(
        self, batch: Batch, members: Sequence[int], ready_us: int, done: float, share: float
    ) -> list[Run | RunError]:
        """Release the hulls of all runs and sail to the scenarios' end."""
        tracer = Tracer(batch.scenarios, batch.bodies, batch.slots, self.keep_s)
        led = {run: batch.fleet.parameters(batch.leading(run)) for run in batch.led}
        leaders = VirtualLeaders(batch.scenarios, led)
        faults = timeline.Timeline(batch)
        for k in range(tracer.ticks):
            t_us = ready_us + k * batch.h_us
            if k > 0:  # the start has already done the tick of the release
                faults.apply(k, t_us)
                batch.tick(t_us)
            if self.watch is not None:
                self.watch(batch, members, k, t_us)
            for run in led:
                leaders.hear(run, batch.fleet.sent(batch.leading(run)), t_us)
            leaders.advance(k, batch.bodies, batch.command, t_us)
            tracer.note(k, batch.fleet.states)
            if k % 100 == 0:
                self.progress(done + share * k / tracer.ticks)
                if len(violations(batch)) == len(members):
                    break
        self.progress(done + share)
        digests = self._finish(batch)
        broken = violations(batch, self.record)
        return [
            broken.get(run)
            or Run(tracer.trace(run), tracer.seconds(run), digests[run] if digests else None)
            for run in range(len(batch.scenarios))
        ]

    def _finish(self, batch: Batch) -> list[str]:
        """Finish the recordings and return their digests."""
        batch.take()
        return [recorder.finish() for recorder in batch.recorders]
