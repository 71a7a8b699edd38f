# SPDX-License-Identifier: MIT
"""The report of an identification: verdict, oddities of the logs, figures, manoeuvres to add."""

from collections.abc import Iterable

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from sil.identify.hull_terms import INDEX, TERMS
from sil.identify.identification import Identification
from sil.identify.score import Score
from sil.identify.vessel_numbers import (
    RATES_RADPS,
    SPEEDS_MPS,
    Boat,
    drag_N,
    parameters,
    yaw_moment_Nm,
)

#: Whether the gains that the firmware derives fit the hull, and the certificate's verdict.
Fit = tuple[bool, str]
# Least R² in open loop over 10 s: below these the hull does not explain its logs.
LEAST_U, LEAST_R = 0.95, 0.8
# The manoeuvres that would determine a term.
_MANOEUVRES = {
    "straights out and back on eight headings": (
        "compass",
        "compass_sin",
        "compass_cos",
        "wind_x",
        "wind_y",
        "wind_n",
        "late_velocity",
        "late_position",
    ),
    "steps of surge ahead and astern, with coast-down": (
        "d11",
        "d11_quadratic",
        "forward",
        "reverse",
        "advance",
        "expo",
        "dead",
    ),
    "spins on the spot, both ways": ("m33", "d33", "d33_quadratic", "antenna_x", "antenna_y"),
    "zig-zags at two speeds": ("m22", "m23", "munk", "late_rate"),
    "circles both ways at three speeds": ("d33_speed", "d22", "d22_quadratic", "d22_speed"),
    "each propeller alone, ahead and astern": ("gain", "gain_reverse"),
    "a pseudo-random sequence of both propellers": ("lag", "dead_time"),
}


def holds(found: Identification) -> bool:
    """Whether the hull predicts the halves that it was not fitted to, and its wiring is usable."""
    scored = [s for s in found.held_out if s is not None]
    good = all(s.u >= LEAST_U and s.r >= LEAST_R for s in scored)
    return bool(scored) and good and not found.wiring.swapped


def sentence(found: Identification) -> str:
    """The verdict."""
    if found.wiring.swapped:
        return f"Not usable as it is: {found.wiring.sentence()}"
    scored = [s for s in found.held_out if s is not None]
    if not scored:
        return "Not judged: no half of the logs has 10 s in which the propellers work"
    word = "Good" if holds(found) else "Doubtful"
    u, v, r = (min(getattr(s, name) for s in scored) for name in "uvr")
    return (
        f"{word}: predictions over 10 s of logs not used for the fit have R² {u:.2f} (speed), "
        f"{r:.2f} (yaw rate), {v:.2f} (sway) and end {max(s.median_m for s in scored):.1f} m off"
    )


def tell(found: Identification, boat: Boat, fit: Fit | None, console: Console) -> None:
    """Print everything; `fit` is None if there is no hull that could be used."""
    console.print(f"[bold {'green' if holds(found) else 'red'}]{sentence(found)}")
    if fit is not None:
        fitting, verdict = fit
        word = "fit" if fitting else "do not fit"
        colour = "green" if fitting else "red"
        console.print(f"[{colour}]The gains that the firmware derives {word} this hull: {verdict}")
    for line in remarks(found):
        console.print(f"[yellow]• {line}")
    console.print(_figures(found, boat))
    console.print(_scores(found.held_out))
    console.print(_terms(found))
    for line in lacking(found):
        console.print(f"[dim]{line}")


def remarks(found: Identification) -> list[str]:
    """Oddities of the logs, as sentences."""
    # Swapped propellers are the verdict itself.
    told = [] if found.wiring.right or found.wiring.swapped else [found.wiring.sentence()]
    k = INDEX["compass"]
    off = np.degrees(found.fit.values[k : k + 3])
    if np.abs(off).max() > 2.0 and np.any(found.intervals.determined[k : k + 3]):
        told.append(
            f"the compass deviates: {off[0]:+.1f}° {off[1]:+.1f}° sin ψ {off[2]:+.1f}° cos ψ"
        )
    return [*told, *found.odd]


def lacking(found: Identification) -> list[str]:
    """Terms that the logs do not determine, and the manoeuvre that would."""
    missing = {
        t.name for t, told in zip(TERMS, found.intervals.determined, strict=True) if not told
    }
    if not missing:
        return ["Every number is determined by these logs."]
    lines = ["Not determined by these logs, and the manoeuvre that would:"]
    for manoeuvre, names in _MANOEUVRES.items():
        here = [TERMS[INDEX[name]].meaning for name in names if name in missing]
        if here:
            lines.append(f"  {'; '.join(here)}: {manoeuvre}")
    return lines


def _figures(found: Identification, boat: Boat) -> Table:
    draws, terms = found.intervals.draws, found.fit.values
    m11, length = boat.surge_mass_kg, found.problem.body.length_m
    rows = [
        (f"drag at {v:g} m/s", drag_N(terms, m11, v), drag_N(draws, m11, v), "N")
        for v in SPEEDS_MPS
    ] + [
        (
            f"yaw moment at {r:g} rad/s",
            yaw_moment_Nm(terms, m11, r, length),
            yaw_moment_Nm(draws, m11, r, length),
            "N m",
        )
        for r in RATES_RADPS
    ]
    k = INDEX["forward"]
    rows.append(("thrust of a propeller, full ahead", m11 * terms[k], m11 * draws[:, k], "N"))
    late = [INDEX["lag"], INDEX["dead_time"]]
    rows.append(("lag and dead time", terms[late].sum(), draws[:, late].sum(axis=1), "s"))
    table = _table(f"The hull, {boat.mass_kg:g} kg", "", "95 %", "")
    for what, value, drawn, unit in rows:
        low, high = found.intervals.of(drawn)
        table.add_row(what, f"{float(value):.3g}", f"{low:.3g} … {high:.3g}", unit)
    for name, number in parameters(found, boat).items():
        table.add_row(name, f"{number:g}", "", "parameter")
    return table


def _scores(scores: Iterable[Score | None]) -> Table:
    table = _table(
        "Open loop over 10 s, propellers working, fitted to the other half",
        "windows",
        "R² u",
        "R² v",
        "R² r",
        "position after 10 s: median; 90 %",
    )
    for half, s in zip(("first half", "second half"), reversed(list(scores)), strict=True):
        if s is None:
            table.add_row(half, "0")
            continue
        numbers = (f"{x:.3f}" for x in (s.u, s.v, s.r))
        table.add_row(half, str(s.windows), *numbers, f"{s.median_m:.2f}; {s.ninetieth_m:.2f} m")
    return table


def _terms(found: Identification) -> Table:
    table = _table("The terms, over the inertia in surge", "", "95 %", "")
    for k, term in enumerate(TERMS):
        low, high = found.intervals.of(found.intervals.draws[:, k])
        untold = "" if found.intervals.determined[k] else "not determined"
        table.add_row(term.meaning, f"{found.fit.values[k]:.3g}", f"{low:.3g} … {high:.3g}", untold)
    return table


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    table.add_column("")
    for column in columns:
        table.add_column(column, justify="right")
    return table
