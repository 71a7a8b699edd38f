# SPDX-License-Identifier: MIT
"""Cases for the product's law: long lines, bad radios, abrupt leaders, heavy hulls.

Their figures are kept in results/fleets.json. The page's table is made from this file, and tests
compare it with their own runs.
"""

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from rich import box
from rich.table import Table

from sil import ROOT
from sil.lockstep.metrics import BoatSummary
from sil.results import SEEDS
from sil.results.claims import CLAIMS, PRODUCT, Bound
from sil.results.figures_json import line, numbers
from sil.results.results_table import PERCENTILE, between, percentile, told
from sil.results.sailing import Job, Outcome

PAGE = ROOT / "sil" / "docs" / "RESULTS.md"
FIGURES = ROOT / "sil" / "results" / "fleets.json"
BEGIN = "<!-- fleets: made by flotilla results --fleets -->\n"

# inputs of the S-curve: surge_N 2 is 0.58 m/s, 3.436 is 1.0 m/s; a yaw moment of 0.3024 N m is 0.35
# rad/s
_S_CURVE = "yaw_sine_Nm=0.3, yaw_sine_rad_s=0.3"
_FASTER = (
    f"leader.input=[{{surge_N=2.0, {_S_CURVE}}}, {{from_s=150.0, surge_N=3.436, {_S_CURVE}}}]",
)
_TURN = ("leader.input=[{surge_N=2.0}, {from_s=150.0, surge_N=2.0, yaw_Nm=0.3024}]",)
_LOSSY = ("link.loss=0.3",)
_RELAYED = ("link.everyone=false", "link.delay_s=0.1", "link.loss=0.1")
_NOISY = (
    "navigation.rate_hz=20.0",
    "navigation.position_noise_m=0.02",
    "navigation.heading_noise_rad=0.0087",
    "navigation.velocity_noise_mps=0.02",
    "navigation.yaw_rate_noise_radps=0.0035",
    "clocks.offset_s=10800.0",
    "clocks.drift_ppm=20.0",
    "link.delay_s=0.1",
)
# each 6 m behind the one before, alternately to one side and the other
_OTTERS = ", ".join(
    f"{{follows={i}, offset_m=[{-6.0 if i else 0.0}, 0.0], eta=[{-3.0 - 6.0 * i}, {side}, -0.3]}}"
    for i, side in enumerate((1.5, -1.5) * 5)
)


@dataclass(frozen=True)
class Case:
    """A scenario at the settings of its claim, with overrides, and its purpose.

    `most`: the greatest figures allowed, by `claims.Bound.key`. `seeds`: with many, a figure is
    the one that `share` of the runs do not exceed; 1: the worst run's. `by_depth`: the page also
    shows the distances from the slots by depth.
    """

    about: str
    scenario: str
    most: dict[str, float]
    overrides: tuple[str, ...] = ()
    seeds: tuple[int | None, ...] = (None,)
    share: float = PERCENTILE
    by_depth: bool = False

    @property
    def jobs(self) -> list[Job]:
        """Its runs."""
        return [Job(self.scenario, PRODUCT, seed, self.overrides) for seed in self.seeds]


# 1.15 × the root's 0.35 rad/s and 0.58 m/s; 1.6 m/s after a step to 1.0 m/s; the law's limits
_CALM = {"rms_error_m": 0.02, "yaw_rate_radps": 0.405, "speed_mps": 0.67}
_AFTER_STEP = {"rms_error_m": 0.02, "speed_mps": 1.6}
_IN_TURN = {"rms_error_m": 0.02, "yaw_rate_radps": 0.8}
_CAPS = {"yaw_rate_radps": 0.8, "speed_mps": 1.5}
_RMS = "rms_error_m"
CASES = (
    Case("20 in a line, 0.2 s radio, all hear all", "line20", _CALM),
    Case("20 in a line, 30 % lost", "line20", _CALM, _LOSSY),
    Case("20 in a line, root 0.58 to 1.0 m/s at 150 s", "line20", _AFTER_STEP, _FASTER),
    Case("20 in a line, that step, 30 % lost", "line20", _AFTER_STEP, (*_FASTER, *_LOSSY)),
    Case("20 in a line, root straight, then 0.35 rad/s", "line20", _IN_TURN, _TURN),
    Case("20 in a line, that turn, 30 % lost", "line20", _IN_TURN, (*_TURN, *_LOSSY)),
    Case(
        "10 relayed only, 0.1 s, 10 % lost a hop",
        "line10",
        {_RMS: 0.10, "yaw_rate_growth": 1.2},
        _RELAYED,
        by_depth=True,
    ),
    Case("20 relayed only, 0.2 s", "line20_relay", _CAPS, by_depth=True),
    Case("20 relayed only, 30 % lost a hop", "line20_relay", _CAPS, _LOSSY, by_depth=True),
    Case(
        f"hulls ±50 %, white noise, 20 Hz unit; 95th percentile of {SEEDS} seeds",
        "mismatch",
        {_RMS: 0.10},
        ("navigation.rate_hz=20.0",),
        tuple(range(1, SEEDS + 1)),
    ),
    *(
        Case(
            f"{rate_hz} Hz units 0.2 s late, unknown to the boats, hulls ±50 %; worst of 100 seeds",
            "late_unit",
            {_RMS: 0.2, "yaw_rate_radps": 0.8},
            ("duration_s=150", f"navigation.rate_hz={rate_hz}.0", "mismatch.share=0.5"),
            tuple(range(1, 101)),
            share=1.0,
        )
        for rate_hz in (10, 20, 50)
    ),
    Case("four Otters, 0.1 s radio", "sea", {_RMS: 0.15}, _NOISY),
    Case("ten Otters in a line, 0.1 s radio", "sea", {_RMS: 0.15}, (f"boat=[{_OTTERS}]", *_NOISY)),
)


@dataclass(frozen=True)
class Row:
    """A case's figure (None: a run failed) and the greatest that is allowed."""

    case: Case
    bound: Bound
    figure: float | None
    most: float

    @property
    def reached(self) -> bool:
        """Whether the figure is allowed."""
        return self.figure is not None and self.figure <= self.most

    @property
    def cells(self) -> list[str]:
        """Its cells on the page."""
        first = self.bound.key == next(iter(self.case.most))
        return [
            self.case.about if first else "",
            self.bound.what,
            told(self.figure, self.bound, PRODUCT),
            f"{self.most:g} {self.bound.unit}",
            "yes" if self.reached else "**NO**",
        ]


def jobs() -> list[Job]:
    """The runs of all cases."""
    return [job for case in CASES for job in case.jobs]


def rows(outcomes: Sequence[Outcome]) -> list[Row]:
    """The table's rows."""
    by_job = {outcome.job: outcome for outcome in outcomes}
    found = []
    for case in CASES:
        bounds = {bound.key: bound for bound in CLAIMS[case.scenario].bounds}
        runs = [by_job[job] for job in case.jobs]
        for key, most in case.most.items():
            figure = percentile(runs, bounds[key], PRODUCT, case.share)
            found.append(Row(case, bounds[key], figure, most))
    return found


def for_page(outcomes: Sequence[Outcome]) -> str:
    """The table in Markdown; below it the distances by depth, and states other than FORMATION."""
    lines = ["| case |  | product | to reach |  |", "|---|---|--:|--:|---|"]
    lines += [f"| {' | '.join(row.cells)} |" for row in rows(outcomes)]
    by_job = {outcome.job: outcome for outcome in outcomes}
    for case in CASES:
        boats = [boat for job in case.jobs for boat in by_job[job].boats]
        if case.by_depth:
            depths = " ".join(f"{boat['rms_error_m']:.3f}" for boat in boats)
            lines += ["", f"{case.about}: RMS distance by depth, m: {depths}."]
        lines += _told_states(case, boats)
    return "\n".join(lines)


def encoded(outcomes: Sequence[Outcome]) -> bytes:
    """Encode as fleets.json: one run per line, 6 digits, non-finite numbers as null."""
    runs = [
        {
            "scenario": outcome.job.scenario,
            "seed": outcome.job.seed,
            "overrides": outcome.job.overrides,
            "failure": outcome.failure,
            "figures": outcome.figures,
            "boats": [
                {key: boat[key] for key in ("rms_error_m", "states")} for boat in outcome.boats
            ],
        }
        for outcome in outcomes
    ]
    text = ",\n".join(map(line, runs))
    return f"[\n{text}\n]\n".encode()


def decoded(content: bytes) -> list[Outcome]:
    """Decode the output of `encoded`."""
    return [
        Outcome(
            Job(run["scenario"], PRODUCT, run["seed"], tuple(run["overrides"])),
            run["failure"],
            boats=run["boats"],
            figures=numbers(run["figures"]),
        )
        for run in json.loads(content)
    ]


def noted() -> list[Outcome]:
    """The figures that the project publishes."""
    return decoded(FIGURES.read_bytes())


def page(outcomes: Sequence[Outcome]) -> str:
    """The page with the table filled in; ValueError if it lacks the marks for it."""
    return between(PAGE.read_text(encoding="utf-8"), BEGIN, for_page(outcomes))


def for_terminal(outcomes: Sequence[Outcome]) -> Table:
    """The table for the terminal."""
    grid = Table("case", "", "product", "to reach", "", box=box.SIMPLE_HEAD, pad_edge=False)
    for row in rows(outcomes):
        *cells, reached = row.cells
        colour = "green" if row.reached else "bold red"
        grid.add_row(*cells, f"[{colour}]{reached.strip('*')}")
    return grid


def _told_states(case: Case, boats: Sequence[BoatSummary]) -> list[str]:
    """One line if a boat was not in FORMATION all the time."""
    seconds: Counter[str] = Counter()
    for boat in boats:
        seconds.update(boat["states"])
    if not seconds.keys() - {"FORMATION"}:
        return []
    means = (f"{state} {total / len(boats):.1f} s" for state, total in seconds.items())
    return ["", f"{case.about}: the mean boat was in {', '.join(means)}."]
