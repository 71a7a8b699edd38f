# SPDX-License-Identifier: MIT
"""The work of a worker: sails a batch of runs and returns their figures and samples."""

import hashlib
import importlib.metadata
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import flotilla

import sil
from sil.campaign.run_outcome import RunResult, result_of
from sil.campaign.sampling import Sampler
from sil.lockstep.world import sail


@dataclass(frozen=True)
class Share:
    """Runs of a campaign, by number, with everything needed to sail them.

    `code`: the result of `code()` where the campaign was started; `parameters`: those of `--param`.
    """

    runs: tuple[int, ...]
    sampler: Sampler
    parameters: Mapping[str, float]
    code: str

    def singles(self) -> Iterator["Share"]:
        """Each of its runs as a batch of its own."""
        return (replace(self, runs=(run,)) for run in self.runs)


@dataclass(frozen=True)
class ShareResult:
    """Results of a batch, and the seconds that a core was busy with it."""

    runs: tuple[RunResult, ...]
    busy_s: float


class OtherCodeError(RuntimeError):
    """A worker has another build or version of this project than the campaign was started with."""


@cache
def code() -> str:
    """SHA-256 of everything on which figures depend: this package, the native module, numpy."""
    digest = hashlib.sha256()
    for path in sorted(Path(sil.__file__ or "").parent.rglob("*.py")):
        digest.update(path.read_bytes())
    digest.update(Path(flotilla.__file__).read_bytes())
    digest.update(importlib.metadata.version("numpy").encode())
    return digest.hexdigest()


def sail_batch(batch: Share) -> ShareResult:
    """Sail a batch; a run that fails leaves a result with the reason.

    Raises OtherCodeError if the figures would differ from those of the campaign's other workers.
    """
    began_s = time.perf_counter()
    if batch.code != code():
        raise OtherCodeError("a worker has another version or build of flotilla")
    return ShareResult(tuple(_results(batch)), time.perf_counter() - began_s)


def failed(batch: Share, reason: str) -> ShareResult:
    """The result of a batch in which no run could be sailed."""
    seeds = [batch.sampler.seed_of(run) for run in batch.runs]
    runs = zip(batch.runs, seeds, strict=True)
    return ShareResult(tuple(RunResult(run, seed, "failed", reason) for run, seed in runs), 0.0)


def _results(batch: Share) -> list[RunResult]:
    try:
        scenarios = [batch.sampler.scenario(run) for run in batch.runs]
        outcomes = sail(scenarios, dict(batch.parameters))
        together = zip(batch.runs, scenarios, outcomes, strict=True)
        return [result_of(*each) for each in together]
    except Exception as error:  # whatever fails, the other runs go on
        if len(batch.runs) == 1:
            return list(failed(batch, f"{type(error).__name__}: {error}").runs)
    return [result for single in batch.singles() for result in _results(single)]
