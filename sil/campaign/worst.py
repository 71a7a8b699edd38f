# SPDX-License-Identifier: MIT
"""Sails the worst run of a campaign again, for its report and for `flotilla view`."""

import json
import tempfile
from pathlib import Path
from typing import Any

from sil.campaign import finished, page_tables
from sil.campaign.sampling import Sampler
from sil.common import files
from sil.lockstep.start import RunError
from sil.lockstep.world import World
from sil.view.recorded import history_of, said_of

NAME = "worst.json"


def write(out: Path, sampler: Sampler, parameters: dict[str, float]) -> bool:
    """Sail the worst run that did not diverge, write its history into the folder `out`.

    `out` has the campaign's tables. Returns False, and writes no file, if there is no such run or
    it cannot be sailed here.
    """
    (out / NAME).unlink(missing_ok=True)
    campaign = finished.tables(out)
    runs = page_tables.worst(campaign)
    if not runs:
        return False
    number = runs[0][0]
    scenario = sampler.scenario(number)
    title = f"{scenario.name}, run {number}, the worst of {campaign.runs.size}"
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "recording.bin"
        try:
            run = World(scenario, parameters).run(recording, lambda _: None)
        except (RunError, ValueError):
            return False
        recorded = recording if recording.is_file() else None
        said = said_of(Path(folder), run.trace, recorded)
    told = history_of(title, run.trace, scenario, said)
    files.replace(out / NAME, json.dumps(told, allow_nan=False).encode())
    return True


def read(out: Path) -> dict[str, Any] | None:
    """The history in worst.json, None if there is no such file. ValueError if it is damaged."""
    path = out / NAME
    if not path.is_file():
        return None
    try:
        told: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is damaged: {error}") from None
    return told
