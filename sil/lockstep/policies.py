# SPDX-License-Identifier: MIT
"""Violations of the firmware's rules, `flotilla.policies()`, as errors of runs."""

from pathlib import Path

from sil.lockstep.batch import Batch
from sil.lockstep.start import RunError


class PolicyViolationError(RunError):
    """A boat broke a rule; the text names boat, time, rule and recording."""


def violations(batch: Batch, recording: Path | None = None) -> dict[int, PolicyViolationError]:
    """The first violation of each run that has one; `recording`: path of a single run's."""
    first: dict[int, PolicyViolationError] = {}
    kept = "" if recording is None else f"; recording: {recording}"
    for agent, t_us, rule in batch.fleet.violations():
        run, boat = divmod(agent - batch.row(0, 1), batch.boats)
        told = f'boat {boat + 1} broke a rule at t = {1e-6 * t_us:.3f} s: "{rule}"{kept}'
        first.setdefault(run, PolicyViolationError(told))
    return first
