# SPDX-License-Identifier: MIT
"""Summarizes a campaign in a few figures, and its computing effort."""

import platform
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from sil.campaign import late
from sil.campaign.run_outcome import RunResult, distances
from sil.campaign.work import ShareResult
from sil.report import headline
from sil.scenario.scenario import Scenario
from sil.view.history import boats_of

_NAMED = 10
"""Greatest number of runs that are listed by number."""


@dataclass
class Effort:
    """The runs sailed since the command began, and their effort; `cores`: the cores available."""

    cores: int = 1
    runs: int = 0
    busy_s: float = 0.0
    wall_s: float = 0.0

    def add(self, result: ShareResult) -> None:
        """Count a batch."""
        self.runs += len(result.runs)
        self.busy_s += result.busy_s


def figures(
    nominal: Scenario, runs: Sequence[RunResult], effort: Effort, digest: str
) -> dict[str, Any]:
    """The figures of campaign.json, in addition to the campaign's identity.

    `error`: each boat's median and 95th percentile of |e|, m, over the `runs` that sailed and their
    whole seconds from `from_s` on; infinite if too many diverged. `closest`: the least distance of
    two boats of a run, None if no run has two. `settled_runs`: the number of runs in which every
    boat came within 0.05 m of its slot and stayed there.
    """
    boat_s = effort.runs * len(nominal.boat) * nominal.duration_s
    counted = Counter(run.outcome for run in runs)
    error_m = distances(runs).transpose(1, 0, 2)
    levels = late.percentiles(error_m, (50.0, 95.0)).tolist()
    return {
        "outcomes": {name: counted[name] for name in ("ok", "diverged", "failed")},
        "error": {
            "from_s": late.from_s(int(nominal.duration_s + 1e-6)),
            "runs": error_m.shape[1],
            "boats": [
                {"boat": i, "p50_m": p50, "p95_m": p95}
                for i, (p50, p95) in enumerate(levels, start=1)
            ],
        },
        "closest": _closest(runs),
        "settled_runs": sum(bool(run.boats) and _settled(run) for run in runs),
        "versions": {
            "python": platform.python_version(),
            "flotilla": version("flotilla-usv"),
            **{name: version(name) for name in ("numpy", "pyarrow")},
        },
        "cores": effort.cores,
        "sailed_runs": effort.runs,
        "wall_s": effort.wall_s,
        "busy_s": effort.busy_s,
        "boat_seconds_per_s": boat_s / effort.wall_s,
        "ticks_per_s_per_core": boat_s * nominal.rate_hz / max(effort.busy_s, 1e-9),
        "efficiency": effort.busy_s / (effort.cores * effort.wall_s),
        "digest": digest,
    }


def _closest(runs: Sequence[RunResult]) -> dict[str, Any] | None:
    near = [(run.min_separation_m, run.run) for run in runs if run.min_separation_m is not None]
    return dict(zip(("distance_m", "run"), min(near), strict=True)) if near else None


def _settled(run: RunResult) -> bool:
    return all(boat["settling_time_s"] is not None for boat in run.boats)


def _ended(nominal: Scenario, runs: Sequence[RunResult], told: Mapping[str, Any]) -> headline.Ended:
    hull_m = max(boat.length_m for boat in boats_of(nominal))
    least_m = [run.min_separation_m for run in runs]
    near = sum(apart is not None and apart < hull_m for apart in least_m)
    outcomes = told["outcomes"]
    return headline.Ended(
        runs=len(runs),
        settled=told["settled_runs"],
        near=near if len(nominal.boat) > 1 else None,
        diverged=outcomes["diverged"],
        failed=outcomes["failed"],
        hull_m=hull_m,
    )


def show(
    console: Console, nominal: Scenario, runs: Sequence[RunResult], told: Mapping[str, Any]
) -> None:
    """Print `figures` and the runs that diverged or failed."""
    error, failed = told["error"], told["outcomes"]["failed"]
    of = f"{error['runs']} of {len(runs)} runs; {failed} failed are not in it"
    whose = of if failed else f"{len(runs)} runs"
    console.print(headline.of_campaign(_ended(nominal, runs, told)).marked, soft_wrap=True)
    title = f"{nominal.name}: |e| from {error['from_s']:g} s on, {whose}"
    console.print(title, soft_wrap=True, markup=False)
    table = Table(min_width=50)
    for heading in ("boat", "median, m", "95th percentile, m"):
        table.add_column(heading, justify="right")
    for boat in error["boats"]:
        table.add_row(str(boat["boat"]), f"{boat['p50_m']:.4f}", f"{boat['p95_m']:.4f}")
    console.print(table)
    if told["closest"] is not None:
        run, distance_m = told["closest"]["run"], told["closest"]["distance_m"]
        console.print(f"closest two boats: {distance_m:.3f} m, in run {run}")
    for outcome in ("diverged", "failed"):
        those = [run for run in runs if run.outcome == outcome]
        for run in those[:_NAMED]:
            console.print(f"[bold red]run {run.run} {outcome}: {escape(run.reason)}")
        if those:
            console.print(f"[bold red]{len(those)} of {len(runs)} runs {outcome}")
    if told["sailed_runs"]:
        console.print(
            f"{told['sailed_runs']} runs in {told['wall_s']:.1f} s: "
            f"{told['boat_seconds_per_s']:,.0f} boat-seconds/s; "
            f"{told['ticks_per_s_per_core']:,.0f} firmware ticks/s a core, "
            f"{told['cores']} cores busy {told['efficiency']:.0%} of the time"
        )
    console.print(f"digest {told['digest'][:16]}")
