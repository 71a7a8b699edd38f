# SPDX-License-Identifier: MIT
"""The tables of sailing boats in sil/docs/MEASUREMENTS.md: measured figures, law and paper."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from sil.lockstep import metrics
from sil.lockstep.world import World
from sil.results import radio_share
from sil.results.claims import BASELINE
from sil.results.results_campaigns import MonteCarlo
from sil.results.results_table import PublishedBound, told
from sil.scenario import scenario

Measured = dict[str, float]

MEASURED_BEGIN = "<!-- measured: made by flotilla results -->\n"
LAW_BEGIN = "<!-- law: made by flotilla results -->\n"

# Limits of the figures: about twice the measured values, or requirements.
DEVIATION_M = 0.03
WANTED: Measured = {
    "diamond": 0.0005,
    "leader_global": 0.016,
    "leader_follow_target": 0.004,
    "leader_far_origin": 0.001,
    "radio_share": radio_share.TARGET_SHARE,
    "radio_share_of_eight": radio_share.EIGHT_SHARE,
    "radio_rms_of_eight": radio_share.EIGHT_RMS_M,
}
_LEADERS = ("leader_global", "leader_follow_target", "leader_far_origin")
_FROM_S = {"diamond": 200, **dict.fromkeys(_LEADERS, 120)}

_LAW = (
    ("nothing disturbs: all within 0.05 m after", "diamond", "settling_s"),
    ("a straight leg", "straight", "rms_error_m"),
    ("0.1 m/s of current", "current", "rms_error_m"),
    (
        "hulls ±50 % off the model, white noise, 95th percentile of {seeds} seeds",
        "mismatch",
        "rms_error_m",
    ),
    ("leaders at 5 Hz, 0.2 s late, 30 % lost", "weak_link", "rms_error_m"),
    ("twenty boats in line ahead, heard 0.2 s late", "line20", "rms_error_m"),
    (
        "four 2 m catamarans in waves, gusts and current: a hull that the law does not model",
        "sea",
        "rms_error_m",
    ),
)


def sail() -> Measured:
    """Largest late distances from the slots, m; radio shares of boats that sign."""
    with tempfile.TemporaryDirectory(prefix="flotilla-") as folder:
        measured = {}
        for name, from_s in _FROM_S.items():
            run = World(scenario.load(name), {}).run(Path(folder) / "run.bin", lambda _: None)
            late = run.trace["t_s"] >= from_s - 1e-6
            measured[name] = float(metrics.distances(run.trace["error"][late]).max())
        return {**measured, **_radio(Path(folder))}


def _radio(folder: Path) -> Measured:
    eight = radio_share.eight(folder, radio_share.PROFILE)
    return {
        "radio_share": radio_share.one(folder)["share"],
        "radio_share_of_eight": eight["share"],
        "radio_rms_of_eight": eight["rms_m"],
    }


def for_measured(table: Sequence[PublishedBound], measured: Measured) -> str:
    """The table of the boats' figures, in Markdown."""
    (deviation,) = (row for row in table if row.bound.key == "deviation_from_reference")
    leaders = "only `GLOBAL_POSITION_INT`, only `FOLLOW_TARGET`, or from an origin 2 km away"
    one, eight = (f"{100.0 * measured[f'radio_share{which}']:.0f} %" for which in ("", "_of_eight"))
    lines = [
        (
            "largest deviation of a formation error, any boat and second",
            told(deviation.baseline, deviation.bound, BASELINE),
            f"{DEVIATION_M:g} m",
        ),
        ("largest distance from the slot from 200 s on", *_metres(("diamond",), measured)),
        (
            f"behind a leader that sends {leaders}: largest distance from the slot from 120 s on",
            *_metres(_LEADERS, measured),
        ),
        (
            "one boat on a serial radio of 57,600 Bd, signed: state and reference at 10 Hz, "
            "position at 1 Hz, other telemetry every 4 s",
            one,
            f"{100.0 * WANTED['radio_share']:.0f} %",
        ),
        (
            "eight boats in a line on one such radio, signed, 0.2 s late, with "
            f"{_told(radio_share.PROFILE)}; worst RMS distance from the slot behind the S-curve",
            f"{eight}; {measured['radio_rms_of_eight']:.2g} m",
            f"{100.0 * WANTED['radio_share_of_eight']:.0f} %; {WANTED['radio_rms_of_eight']:g} m",
        ),
    ]
    return _markdown(("", "measured", "limit"), "|---|---|---|", lines)


def for_law(table: Sequence[PublishedBound], campaigns: Sequence[MonteCarlo]) -> str:
    """The table that compares the product's law with the paper's, in Markdown."""
    head = "300 s in lockstep, worst boat: RMS distance from the slot over the last third"
    lines: list[tuple[str, ...]] = []
    for about, name, key in _LAW:
        (row,) = (row for row in table if (row.scenario, row.bound.key) == (name, key))
        lines.append((about.format(seeds=row.seeds), *row.cells[2:4]))
    worst = (f"{max(high for _, high in campaign.late_m):.3f} m" for campaign in campaigns)
    runs = campaigns[0].ended.total()
    about = f"{runs} random starts, hulls ±50 %, white noise ([the paper's Fig. 2](RESULTS.md))"
    lines.append((f"{about}: 95th percentile of the worst boat after 100 s", *worst))
    return _markdown((head, "paper's law", "product's"), "|---|--:|--:|", lines)


def _told(parameters: Measured) -> str:
    return ", ".join(f"`{name}` {value:g}" for name, value in parameters.items())


def _metres(names: Sequence[str], measured: Measured) -> tuple[str, str]:
    return (
        ", ".join(f"{measured[name]:.2g} m" for name in names),
        ", ".join(f"{WANTED[name]:g} m" for name in names),
    )


def _markdown(head: tuple[str, ...], columns: str, lines: Sequence[tuple[str, ...]]) -> str:
    first, *others = (f"| {' | '.join(cells)} |" for cells in (head, *lines))
    return "\n".join([first, columns, *others])
