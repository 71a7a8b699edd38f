# SPDX-License-Identifier: MIT
"""Sails a run of a campaign again, alone, and checks that it belongs to the folder's campaign."""

import json
from dataclasses import asdict
from pathlib import Path

from sil.campaign import finished
from sil.campaign.campaign_files import CampaignError, Identity
from sil.campaign.finished import Campaign
from sil.campaign.run_outcome import motion_digest
from sil.lockstep import trace_file

_WHAT = ("scenario", "document", "parameters", "seed")


def place(folder: Path, run: int) -> Path:
    """The folder of a run that is sailed again."""
    return folder / "runs" / str(run)


def check(folder: Path, identity: Identity, run: int) -> None:
    """CampaignError if the campaign in `folder` is not `identity`, or lacks the run.

    The code may differ: `is_same` returns whether the boats moved in the same way.
    """
    path = folder / "campaign.json"
    if not path.is_file():
        return
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        runs = int(known["runs"])
    except (ValueError, KeyError, TypeError) as error:
        raise CampaignError(f"{path} cannot be read: {error!r}") from None
    now = json.loads(json.dumps(asdict(identity)))
    others = [key for key in _WHAT if known.get(key) != now[key]]
    if others:
        raise CampaignError(
            f"{folder} holds a campaign with other {', '.join(others)}, made by "
            f"{known.get('command')}; to replay a run add --run to that, or choose another --out"
        )
    if not 0 <= run < runs:
        raise CampaignError(f"{folder} holds runs 0 to {runs - 1}, no run {run}")


def is_finished(folder: Path) -> bool:
    """Whether the campaign in `folder` has its tables."""
    return (folder / "table.parquet").is_file() and not (folder / "parts").is_dir()


def is_same(campaign: Campaign, run: int) -> bool:
    """Whether the run was sailed again, with the same motion, bit for bit, as in the table."""
    folder = place(campaign.folder, run)
    if not (folder / trace_file.NAME).is_file():
        return False
    return (
        motion_digest(trace_file.read(folder, ("t_s", "eta", "nu")))
        in campaign.digest[campaign.runs == run]
    )


def told(folder: Path, run: int) -> str:
    """A sentence on the run just sailed, if the campaign is finished."""
    if is_same(finished.read(folder), run):
        return f"run {run}: the same motion as in the campaign's table, bit for bit"
    return f"[bold red]run {run}: not the motion of the campaign's table: other code or machine"
