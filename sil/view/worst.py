# SPDX-License-Identifier: MIT
"""The worst run of a campaign, sailed again with its recording."""

from pathlib import Path
from typing import Any

from rich.console import Console

from sil.campaign import finished, page_tables, replay
from sil.campaign.finished import Campaign
from sil.campaign.sampling import Sampler
from sil.toml_errors import Source
from sil.view.recorded import history_of_run


def worst_run(campaign: Campaign) -> int:
    """The first of the report's worst runs; where none ended well, the first that did not."""
    runs = [run for run, _ in page_tables.worst(campaign) or page_tables.lost(campaign)[0]]
    if not runs:
        raise ValueError(f"{campaign.folder}: no run is in the campaign's table")
    return runs[0]


def history_of_worst(
    folder: Path, console: Console, length_m: float | None = None
) -> dict[str, Any]:
    """The history of the worst run of the campaign in `folder`.

    It is sailed into the folder where `campaign --run` leaves it, unless it is there already.
    ValueError where there is no finished campaign; StartError where the run cannot be started.
    """
    campaign = finished.read(folder)
    run = worst_run(campaign)
    out = replay.place(folder, run)
    if not (replay.is_same(campaign, run) and (out / "recording.bin").is_file()):
        _sail(campaign, run, out, console)
    history = history_of_run(out, length_m)
    return {
        **history,
        "title": f"{campaign.scenario}, run {run}, the worst of {campaign.runs.size}",
    }


def _sail(campaign: Campaign, run: int, out: Path, console: Console) -> None:
    # what draws pictures is not needed by who looks only
    from sil import run as single  # noqa: PLC0415
    from sil.campaign import report  # noqa: PLC0415

    header = campaign.header
    document = dict(header["document"])
    source = Source(f"{campaign.folder}/campaign.json", document, {})
    sampler = Sampler(source, header["seed"])
    command = f"{header.get('command')} --run {run}"
    single.run(sampler.scenario(run), out, dict(header["parameters"]), command, console)
    console.print(replay.told(campaign.folder, run))
    report.write(campaign.folder)
