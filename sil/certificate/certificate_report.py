# SPDX-License-Identifier: MIT
"""The certificate as text: the verdict, then tables for a terminal of 80 columns.

Numbers in brackets refer to Wang and Loría's equations.
"""

import math
from collections.abc import Iterable

from rich import box
from rich.console import Console
from rich.table import Table

from sil.certificate import notes, verdict
from sil.certificate.certificate import Case, Certificate, Leg
from sil.certificate.chain import Chain
from sil.certificate.margins import Margins
from sil.certificate.references import Reference
from sil.certificate.report_search import search_rows
from sil.certificate.small_gain import MOST_K_X

_SHOWN = 3  # components of the slowest mode
_KINDS = {
    "periodic": "periodic",
    "turning": "a constant turn",
    "straight": "a straight leg",
    "rest": "at rest",
}


def tell(certificate: Certificate, console: Console) -> None:
    """Print the whole certificate, the verdict first."""
    colour = "green" if verdict.holds(certificate) else "red"
    console.print(f"[bold {colour}]{verdict.sentence(certificate)}")
    for leg in certificate.legs:
        console.print(_reference_table(leg))
        console.print(_cases_table(leg))
        if isinstance(leg.chain, Chain) and leg.margins is not None:
            console.print(_chain_table(leg.chain, leg.margins))
    if certificate.search is not None:
        table = _table("The gains with the fastest decay, by a coarse search")
        console.print(_filled(table, search_rows(certificate, certificate.search)))
    for note in notes.notes(certificate):
        console.print(f"[dim]{note}")


def _reference_table(leg: Leg) -> Table:
    reference = leg.reference
    since = notes.listed(leg.from_s)
    table = _table(f"The leader from {since} s on: {_KINDS[reference.kind]}")
    rows = [
        ("greatest yaw rate |ω_d|", f"{reference.omega_max:.4f} rad/s"),
        ("greatest yaw acceleration |ω̇_d|", f"{reference.omega_dot_max:.4f} rad/s²"),
        ("period T", period(reference)),
        ("persistent excitation μ (26)", _excitation(reference)),
    ]
    return _filled(table, rows)


def period(reference: Reference) -> str:
    """T of eq:PE, or the reason why there is none."""
    if reference.T_s is None:
        return "none: the leader does not turn"
    if reference.kind == "turning":
        return "any; a short one, which suits the formulas best"
    return f"{reference.T_s:.3f} s, the period of the input"


def _excitation(reference: Reference) -> str:
    if reference.mu == 0.0:
        return "0: no persistent excitation, the paper's theorem does not apply"
    if reference.kind == "turning":
        return f"T × {reference.omega_max**2:.4g} rad²/s²"
    return f"{reference.mu:.4g} rad²/s"


def _cases_table(leg: Leg) -> Table:
    table = Table(box=box.SIMPLE_HEAD, title_justify="left")
    table.add_column(no_wrap=True, style="dim")
    for case in leg.cases:
        table.add_column(verdict.name(case.boats), justify="right")
    columns = [[*_theory(case), *_loops(case), *_propellers(case)] for case in leg.cases]
    for row in zip(*columns, strict=True):
        table.add_row(row[0][0], *(text for _, text in row))
    return table


def _theory(case: Case) -> Iterable[tuple[str, str]]:
    test, own = case.small_gain, case.setup.parameters
    yield "gains k_x, k_ψ (1/s)", f"{own['LAW_KX']:g}, {own['LAW_KPSI']:g}"
    yield "bound on yaw motion ω̄_d (27) (rad/s)", _number(test.bound)
    yield "  holds", "yes" if test.bound_holds else "no"
    yield "small gain, position γ1 (38)", _number(test.gamma1)
    yield "small gain, sway γ2 (40)", _number(test.gamma2)
    yield "  γ1 γ2, must be less than 1", _number(test.product)
    yield "  largest k_x (1/s)", _or_none(test.k_x_product)
    yield "estimate (41) with (1 + k_x)²", _number(test.above_square_of_sum)
    yield "  largest k_x (1/s)", _or_none(test.k_x_square_of_sum)
    yield "estimate (41) with 1 + k_x²", _number(test.above_sum_of_squares)
    yield "  largest k_x (1/s)", _or_none(test.k_x_sum_of_squares)
    yield "least k_du, Proposition 1 (kg/s)", f"{test.k_du_least:.3g}"
    yield "  k_du", f"{own['LAW_KDU']:g}"


def _loops(case: Case) -> Iterable[tuple[str, str]]:
    floquet, loop = case.floquet, case.sampled
    values = "\n".join(_multiplier(value) for value in floquet.multipliers)
    yield f"paper's nominal loop (24),\n  |multipliers| in {floquet.period_s:.4g} s", "\n" + values
    yield "  decay (1/s)", f"{floquet.decay:z.4f}"
    yield f"sampled loop, radius in {loop.window_s:.4g} s", f"{loop.radius:.5g}"
    yield "  decay (1/s)", f"{loop.decay:z.4f}"
    yield "  slowest is in", ", ".join([*loop.slowest][:_SHOWN])
    yield "  decay with LAW_OBS_BW =\n    LAW_CUR_BW = 0 (1/s)", f"{loop.decay_of_law:z.4f}"
    yield "  neutral modes (hull at rest)", str(loop.neutral)
    wrong = loop.misled
    yield "  current along the leg wrong by\n    (m/s)", f"±{wrong.wrong_mps:.2g}" if wrong else "–"
    yield "    moves the boat by (m)", f"{wrong.off_m:.4f}" if wrong else ""
    yield "    changes a thrust by (N)", f"{wrong.thrust_N:.4f}" if wrong else ""
    x, y, psi = loop.error
    yield "  off the slot (m)", f"{math.hypot(x, y):.4f}" if loop.steady else "not steady"
    yield "    heading (°)", f"{math.degrees(psi):.3f}" if loop.steady else ""


def _propellers(case: Case) -> Iterable[tuple[str, str]]:
    need, pair = case.thrust, case.setup.propellers
    weaker = min(pair.port_gain, pair.stbd_gain)
    limits = f"{-weaker * pair.reverse_max_N:.3g} … {weaker * pair.forward_max_N:.3g}"
    yield "propeller limits (N)", limits.replace("-", "−")
    span = f"{need.least_N:z.2f} … {need.most_N:z.2f}"
    yield "  the slot needs (N)", span.replace("-", "−")
    finite = math.isfinite(need.margin)
    yield "  margin (%)", f"{100.0 * need.margin:.1f}".replace("-", "−") if finite else "no reverse"
    yield "  least margin", f"{need.side}, {'ahead' if need.direction == 'forward' else 'astern'}"
    yield "    at time in window (s)", f"{need.at_s:.1f}"


def _chain_table(chain: Chain, margins: Margins) -> Table:
    most = len(chain.depths)
    depth = f"{chain.certified}" + (", or more" if chain.certified == most else "")
    last = chain.depths[len(chain.path) - 1]
    rows = [
        ("every boat steers by", "the reference" if chain.reference else "the boat before it"),
        ("greatest gain of a hop in yaw, surge", _most(chain.yaw.hop, chain.surge.hop)),
        (
            f"  from the root to boat {chain.path[-1]}",
            _most(*(axis.root[len(chain.path) - 1] for axis in (chain.yaw, chain.surge))),
        ),
        (
            "its peak yaw rate, speed, RMS off slot",
            f"{last.yaw_rate:.2g} rad/s, {last.speed:.2g} m/s, {last.off_slot_m:.2g} m",
        ),
        ("certified to depth (FORM_DEPTH)", depth),
        ("margin of radio delay (s)", f"{margins.delay_s:.2f}"),
        ("margin of mass and damping (%)", f"{100.0 * margins.mismatch:.0f}"),
    ]
    return _filled(_table(f"The worst chain: {verdict.name(chain.path)}"), rows)


def _most(yaw: list[float], surge: list[float]) -> str:
    return f"{max(yaw):.3g}, {max(surge):.3g}"


def _table(title: str) -> Table:
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, show_header=False)
    table.add_column(no_wrap=True, style="dim")
    table.add_column()
    return table


def _filled(table: Table, rows: Iterable[tuple[str, str]]) -> Table:
    for row in rows:
        table.add_row(*row)
    return table


def _multiplier(value: complex) -> str:
    # smaller values are the integrator's tolerance
    return f"{abs(value):.3g}" if abs(value) > 1e-9 else "< 1e-9"


def _or_none(value: float | None) -> str:
    if value is None:
        return "none"
    return f"over {MOST_K_X:g}" if value >= MOST_K_X else f"{value:.4f}"


def _number(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:.4g}"
