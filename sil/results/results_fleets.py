# SPDX-License-Identifier: MIT
"""Cases for the product's law: long lines, bad radios, abrupt leaders, unknown hulls."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from sil.results import SEEDS
from sil.results.claims import CLAIMS, PRODUCT
from sil.results.results_table import percentile, told
from sil.results.sailing import Job, Outcome

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
    """A scenario at the settings of its claim, with overrides, and its purpose."""

    about: str
    wanted: str
    scenario: str
    overrides: tuple[str, ...] = ()
    seeds: tuple[int | None, ...] = (None,)
    by_depth: bool = False


_CALM = "≤ 0.02 m; ≤ 1.15 × the root's"
_CAPS = "≤ LAW_R_MAX 0.8 rad/s, LAW_U_MAX 1.5 m/s; nobody silently out of formation"
_MANY = tuple(range(1, SEEDS + 1))
CASES = (
    Case("20 in a line, 0.2 s radio, all hear all", _CALM, "line20"),
    Case("the same, 30 % lost", _CALM, "line20", _LOSSY),
    Case(
        "the same, root 0.58 to 1.0 m/s at 150 s", "≤ 0.02 m after it; ≤ 1.6 m/s", "line20", _FASTER
    ),
    Case("the same with 30 % lost", "≤ 0.02 m after it; ≤ 1.6 m/s", "line20", (*_FASTER, *_LOSSY)),
    Case("root straight, then 0.35 rad/s", "≤ 0.02 m after it; ≤ 0.8 rad/s", "line20", _TURN),
    Case("the same with 30 % lost", "≤ 0.02 m after it; ≤ 0.8 rad/s", "line20", (*_TURN, *_LOSSY)),
    Case(
        "10 relayed only, 0.1 s, 10 % lost a hop",
        "≤ 0.10 m; boat 10 ≤ 1.2 × boat 2",
        "line10",
        _RELAYED,
        by_depth=True,
    ),
    Case("20 relayed only, 0.2 s", _CAPS, "line20_relay", by_depth=True),
    Case("the same, 30 % lost a hop", _CAPS, "line20_relay", _LOSSY, by_depth=True),
    Case("hulls ±50 %, white noise", "≤ 0.10 m", "mismatch", (), _MANY),
    Case("the same, 20 Hz unit", "≤ 0.10 m", "mismatch", ("navigation.rate_hz=20.0",), _MANY),
    Case("noisy", "≤ 0.03 m; ≤ 0.2 N a tick", "noisy"),
    Case("four Otters, 0.1 s radio", "≤ 0.15 m", "sea", _NOISY),
    Case("ten Otters in a line, the same", "≤ 0.15 m", "sea", (f"boat=[{_OTTERS}]", *_NOISY)),
)


def jobs() -> list[Job]:
    """The runs of all cases."""
    return [job for case in CASES for job in _jobs(case)]


def for_terminal(outcomes: Sequence[Outcome]) -> str:
    """One paragraph per case; with many seeds, figures are 95th percentiles."""
    by_job = {outcome.job: outcome for outcome in outcomes}
    lines = []
    for case in CASES:
        runs = [by_job[job] for job in _jobs(case)]
        lines += [f"{case.about}: {case.wanted}", f"    {', '.join(_figures(case, runs))}"]
        if case.by_depth:
            depths = (f"{boat['rms_error_m']:.3f}" for boat in runs[0].boats)
            lines.append(f"    rms_error_m by depth: {' '.join(depths)}")
        lines += _told_states(runs)
    return "\n".join(lines)


def _jobs(case: Case) -> list[Job]:
    return [Job(case.scenario, PRODUCT, seed, case.overrides) for seed in case.seeds]


def _figures(case: Case, runs: Sequence[Outcome]) -> list[str]:
    bounds = [bound for bound in CLAIMS[case.scenario].bounds if PRODUCT in bound.laws]
    return [f"{b.key} {told(percentile(runs, b, PRODUCT), b, PRODUCT)}" for b in bounds]


def _told_states(runs: Sequence[Outcome]) -> list[str]:
    """One line if a boat was not in FORMATION all the time."""
    boats = [boat for run in runs for boat in run.boats]
    seconds: Counter[str] = Counter()
    for boat in boats:
        seconds.update(boat["states"])
    if seconds.keys() == {"FORMATION"}:
        return []
    means = (f"{state} {total / len(boats):.1f} s" for state, total in seconds.items())
    return [f"    mean of a boat: {', '.join(means)}"]
