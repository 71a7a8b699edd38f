# SPDX-License-Identifier: MIT
"""The page of a campaign: pictures after the paper's Figs. 1 and 2, tables, runs to replay."""

import base64
from collections.abc import Callable, Iterable, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from matplotlib.figure import Figure

from sil.campaign import finished, nominal, page_tables, pictures, rerun, samples, worst
from sil.campaign.finished import FAILED, Campaign
from sil.campaign.samples import Samples
from sil.common import files
from sil.common.colours import colour_of
from sil.plant.hull import Array
from sil.report import headline, plots, run_report
from sil.report.comparison import png
from sil.scenario.sections import Leader
from sil.view import page as view

_COPY = '<button type="button" class="copy">Copy</button>'
_PAGE = Template((Path(__file__).parent / "report.html").read_text(encoding="utf-8"))


def write(out: Path, worst_sailed: Callable[[], object] = lambda: None) -> None:
    """Write `out`/report.html, which needs no other file, from the campaign's files in `out`.

    `worst_sailed` returns once the worst run is in `out`, or could not be sailed. ValueError, in
    one line, if a file is missing or does not belong to a campaign.
    """
    campaign = finished.tables(out)
    sampled, trace = samples.read(campaign), nominal.read(out)
    drawn = _formation(campaign, trace), _errors(campaign, sampled, trace)
    worst_sailed()
    text = page(campaign, sampled, drawn, worst.read(out))
    files.replace(out / "report.html", text.encode())


def page(
    campaign: Campaign,
    sampled: Samples,
    drawn: tuple[str, str],
    worst_told: dict[str, Any] | None,
) -> str:
    """The report as one HTML page; `drawn`: pictures of the nominal run and of all errors.

    `worst_told`: the history of the worst run, from worst.json.
    """
    header, found = campaign.header, headline.of_campaign(page_tables.ended(campaign))
    last_lost, more = page_tables.lost(campaign)
    speed, wall_s = header.get("boat_seconds_per_s"), header.get("wall_s")
    return _PAGE.substitute(
        style=run_report.STYLE,
        scenario=escape(campaign.scenario),
        seed=header["seed"],
        runs=campaign.runs.size,
        boats=campaign.boats,
        duration=f"{sampled.t_s.max(initial=0.0):g} s",
        wall="–" if wall_s is None else f"{wall_s:.1f} s",
        speed="–" if speed is None else f"{speed:,.0f} boat-seconds per second",
        level=found.level,
        verdict=escape(found.text),
        late=f"{sampled.late_s:g}",
        formation=drawn[0],
        errors=drawn[1],
        percentiles=_table(page_tables.ERRORS, page_tables.errors(campaign, sampled)),
        of=_of(campaign),
        lost=_replays(campaign, page_tables.LOST, last_lost),
        more=f"and {more} more, in table.parquet" if more else "",
        near=_replays(campaign, page_tables.NEAR, page_tables.near(campaign)),
        worst=_replays(campaign, page_tables.WORST, page_tables.worst(campaign)),
        replay=_replay(worst_told),
        thrust=_table(page_tables.THRUST, page_tables.thrust(campaign)),
        states=_table(*page_tables.states(campaign)),
        separation=escape(page_tables.separation(campaign)),
        command=escape(str(header.get("command"))),
        digest=escape(str(header.get("digest", "none"))),
    )


def _replay(told: dict[str, Any] | None) -> str:
    if told is None:
        return "<p>None was sailed again.</p>"
    return view.frame_with(told, told["title"])


def _of(campaign: Campaign) -> str:
    count, failed = campaign.runs.size, int((campaign.outcome == FAILED).sum())
    return (
        f"{count - failed} of {count} runs; {failed} failed are not in it" if failed else "all runs"
    )


def _formation(campaign: Campaign, trace: dict[str, Array] | None) -> str:
    if trace is None:
        return "<p>The nominal run was not sailed, or could not be started.</p>"
    about = "Paths of the boats and of their leader, with the formation at several times"
    return _picture(plots.formation(campaign.scenario, trace, _root(campaign)), about)


def _errors(campaign: Campaign, sampled: Samples, trace: dict[str, Array] | None) -> str:
    if sampled.error_m.size == 0:
        return "<p>No run sailed.</p>"
    figure = errors_figure(campaign, sampled, trace)
    return _picture(figure, "Envelopes of each boat's distance from its slot over time")


def errors_figure(campaign: Campaign, sampled: Samples, trace: dict[str, Array] | None) -> Figure:
    """After the paper's Fig. 2: each boat's distance from its slot over all runs that sailed."""
    envelopes = finished.columns(campaign.folder, "envelopes")
    shown = pictures.Errors(envelopes, sampled, trace)
    return pictures.errors(campaign.scenario, shown, _pairs(campaign))


def _root(campaign: Campaign) -> str:
    """The name of agent 0 in the pictures, from `sil.scenario.sections.Leader`."""
    boat = campaign.header.get("document", {}).get("leader", {}).get("boat")
    return Leader(boat=boat).name


def _pairs(campaign: Campaign) -> list[str]:
    """Each boat's label: with its leader if campaign.json names it."""
    boats = campaign.header.get("document", {}).get("boat", [])
    names, root = [], _root(campaign)
    for i in range(campaign.boats):
        leader = boats[i].get("follows") if i < len(boats) else None
        behind = {None: "", 0: f" behind the {root}"}.get(leader, f" behind boat {leader}")
        names.append(f"boat {i + 1}{behind}")
    return names


def _picture(figure: Figure, about: str) -> str:
    data = base64.b64encode(png(figure)).decode()
    image = f'<img alt="{escape(about)}" src="data:image/png;base64,{data}">'
    return f'<div class="wide picture">{image}</div>'


def _replays(campaign: Campaign, head: Sequence[str], rows: Iterable[tuple[int, list[str]]]) -> str:
    """Rows of runs, each with the command that replays it; runs with a report are linked to it."""
    texts, command = [], campaign.header.get("command")
    for run, cells in rows:
        replayed = rerun.is_same(campaign, run)
        link = f'<a href="runs/{run}/report.html">report</a>' if replayed else "not replayed"
        again = f"<code>{escape(f'{command} --run {run}')}</code> {_COPY}"
        texts.append([*(escape(cell) for cell in cells), again, link])
    return _html([*map(escape, head), "replay it with", ""], texts) if texts else "<p>None.</p>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return _html([*map(escape, head)], [[escape(cell) for cell in row] for row in rows])


def _html(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of HTML texts; the first cell of a boat's row has the boat's colour."""
    lines = ["<tr>" + "".join(f"<th>{cell}</th>" for cell in head) + "</tr>"]
    for row in rows:
        colour = f' style="--boat: {colour_of(int(row[0]))}"' if head[0] == "boat" else ""
        lines.append(f"<tr{colour}>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>")
    return '<div class="wide"><table>\n' + "\n".join(lines) + "\n</table></div>"
