# SPDX-License-Identifier: MIT
"""What a run is in which a boat broke one of the firmware's rules, `flotilla.policies()`."""

from pathlib import Path

from sil.lockstep.batch import Batch
from sil.lockstep.start import RunError


class PolicyViolationError(RunError):
    """A boat broke a rule: which boat, when, which rule, and where the recording is."""


def violations(batch: Batch, recording: Path | None = None) -> dict[int, PolicyViolationError]:
    """The first violation of each run that has one; `recording`: where a single run's is kept."""
    first: dict[int, PolicyViolationError] = {}
    kept = "" if recording is None else f"; recording: {recording}"
    for agent, t_us, rule in batch.fleet.violations():
        run, boat = divmod(agent - batch.row(0, 1), batch.boats)
        told = f'boat {boat + 1} broke a rule at t = {1e-6 * t_us:.3f} s: "{rule}"{kept}'
        first.setdefault(run, PolicyViolationError(told))
    return first
