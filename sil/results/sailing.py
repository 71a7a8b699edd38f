# SPDX-License-Identifier: MIT
"""Sails many runs at once in processes; keeps each run's figures and a thinned trace."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

from sil.common import pool
from sil.lockstep import metrics
from sil.lockstep.metrics import BoatSummary
from sil.lockstep.world import Run, World
from sil.plant.hull import Array
from sil.results.claims import CLAIMS
from sil.scenario import scenario
from sil.scenario.law import Law
from sil.scenario.scenario import Scenario

_SAMPLES = 1500


class Job(NamedTuple):
    """A scenario to sail with a law, at the settings of its claim; `seed` None: the scenario's."""

    scenario: str
    law: Law
    seed: int | None = None
    overrides: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.scenario}, {self.law}" + (f", seed {self.seed}" if self.seed else "")


@dataclass(frozen=True)
class Outcome:
    """The result of a run, or the reason why it failed.

    `figures` by `claims.Bound.key`; `trace`: t_s, eta, error at evenly spaced ticks.
    """

    job: Job
    failure: str = ""
    digest: str | None = None
    boats: list[BoatSummary] = field(default_factory=list)
    min_separation_m: float | None = None
    figures: dict[str, float] = field(default_factory=dict)
    trace: dict[str, Array] = field(default_factory=dict)


def sail_all(jobs: Sequence[Job], workers: int, tell: Callable[[Outcome], None]) -> list[Outcome]:
    """Sail all jobs in `workers` processes; return outcomes in the order of the jobs.

    `tell` is called with each outcome. A run that fails or kills its process has an outcome with
    the failure. An interrupt ends all processes.
    """
    outcomes: dict[Job, Outcome] = {}

    def note(job: Job, outcome: Outcome) -> None:
        outcomes[job] = outcome
        tell(outcome)

    pool.prepare(["sil.results.sailing"])
    with tempfile.TemporaryDirectory(prefix="flotilla-") as folder:
        for job in pool.run(partial(sail, folder=Path(folder)), jobs, workers, note):
            note(job, Outcome(job, "the process died"))
    return [outcomes[job] for job in jobs]


def sail(job: Job, folder: Path) -> Outcome:
    """Sail one job; its recording is written to `folder` and deleted."""
    try:
        with tempfile.TemporaryDirectory(dir=folder) as own:
            chosen = scenario_of(job)
            return outcome(job, World(chosen, {}).run(Path(own) / "recording.bin", lambda _: None))
    except Exception as error:  # the other runs must go on
        return Outcome(job, f"{type(error).__name__}: {error}")


def scenario_of(job: Job) -> Scenario:
    """The job's scenario with its law, seed and overrides."""
    seed = [] if job.seed is None else [f"seed={job.seed}"]
    overrides = [*CLAIMS[job.scenario].settings(job.law), *seed, *job.overrides]
    return scenario.load(job.scenario, overrides, job.law)


def outcome(job: Job, run: Run) -> Outcome:
    """The result of a job's run."""
    trace, bounds = run.trace, CLAIMS[job.scenario].bounds
    step = max(1, trace["t_s"].size // _SAMPLES)
    return Outcome(
        job,
        digest=run.digest,
        boats=metrics.boats(trace["t_s"], trace["error"], trace["thrust"], run.states),
        min_separation_m=metrics.min_separation_m(trace["eta"]),
        figures={bound.key: bound.figure(trace) for bound in bounds if job.law in bound.laws},
        # copies: a view would carry the whole trace to the parent
        trace={name: trace[name][::step].copy() for name in ("t_s", "eta", "error")},
    )
