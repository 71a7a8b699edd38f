# SPDX-License-Identifier: MIT
"""The worst run of a campaign, sailed again for the report to replay."""

import json
from pathlib import Path
from typing import Any

from sil import files
from sil.campaign import finished, page_tables
from sil.campaign.sampling import Sampler
from sil.start import RunError
from sil.view import history
from sil.world import sail

NAME = "worst.json"
_SAMPLE_S = 0.1


def write(out: Path, sampler: Sampler, parameters: dict[str, float]) -> bool:
    """Sail the worst run that did not diverge, write its history into the folder `out`.

    `out` has the campaign's tables. False, and no file, where there is no such run, or it cannot be
    sailed here as it was.
    """
    (out / NAME).unlink(missing_ok=True)
    runs = page_tables.worst(finished.tables(out))
    if not runs:
        return False
    number = runs[0][0]
    scenario = sampler.scenario(number)
    (run,) = sail([scenario], parameters, keep_s=_SAMPLE_S)
    if isinstance(run, RunError):
        return False
    boats = history.boats_of(scenario)
    told = history.of_trace(run.trace, f"{scenario.name}, run {number}", boats)
    files.replace(out / NAME, json.dumps(told, allow_nan=False).encode())
    return True


def read(out: Path) -> dict[str, Any] | None:
    """The history in worst.json, None where `out` has none."""
    path = out / NAME
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
