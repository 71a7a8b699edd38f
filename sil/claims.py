# SPDX-License-Identifier: MIT
"""What the law must show: the scenarios, and what the figures of their runs must reach."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from sil import figures
from sil.figures import Trace
from sil.law import Law

BASELINE: Law = "paper"
PRODUCT: Law = "product"
LAWS = (BASELINE, PRODUCT)


@dataclass(frozen=True)
class Bound:
    """A figure of a run and what it must reach.

    `key` names it in results.json, `what` and `unit` for people. `reached` judges the baseline's
    and the product's figure, in this order; one that is infinite or NaN reaches nothing.
    """

    key: str
    what: str
    unit: str
    figure: Callable[[Trace], float]
    to_reach: str
    reached: Callable[[float, float], bool]
    laws: tuple[Law, ...] = LAWS


@dataclass(frozen=True)
class Claim:
    """A scenario in a few words, its bounds, the first one `limit_m` on the distance from the slot.

    `map_s`: how much of the run its map shows. `many_seeds`: figures are 95th percentiles.
    """

    about: str
    limit_m: float
    others: tuple[Bound, ...] = ()
    map_s: float = 60.0
    many_seeds: bool = False

    @property
    def bounds(self) -> tuple[Bound, ...]:
        """All bounds, that on the distance from the slot first."""
        what = "RMS distance from the slot, last third"
        return (_at_most(self.limit_m, "rms_error_m", what, "m", figures.rms_error_m), *self.others)


def _at_most(
    limit: float, key: str, what: str, unit: str, figure: Callable[[Trace], float]
) -> Bound:
    return Bound(key, what, unit, figure, f"{limit:g} {unit}", lambda _, own: own <= limit)


_SETTLED = Bound(
    "settling_s",
    "time until all stay within 0.05 m",
    "s",
    figures.settling_s,
    "1.5 × sooner",
    lambda baseline, own: math.isfinite(own) and baseline >= 1.5 * own,
)
_AS_THE_PAPER = Bound(
    "deviation_from_reference",
    "largest deviation from the continuous-time solution",
    "m",
    figures.deviation_from_reference,
    "0.03 m",
    lambda baseline, _: baseline <= 0.03,
    laws=(BASELINE,),
)
_EFFORT = Bound(
    "thrust_rms_N",
    "RMS thrust over the whole run",
    "N",
    figures.thrust_rms_N,
    "0.75 × the paper's",
    lambda baseline, own: own <= 0.75 * baseline,
)
_SMOOTH = _at_most(
    0.2,
    "thrust_change_N",
    "RMS change of thrust from tick to tick, last third",
    "N",
    figures.thrust_change_N,
)
_NO_CIRCLE = _at_most(
    0.15,
    "turns_at_a_stop",
    "heading swept while the leader is stopped; a circle is 1",
    "turn",
    figures.turns_at_a_stop,
)


def _overshoot(limit_m: float) -> Bound:
    what = "overshoot: how far from the slot again, once within 2 m of it"
    return _at_most(limit_m, "overshoot_m", what, "m", figures.overshoot_m)


# Bounds are about twice the figures that were measured.
CLAIMS = {
    "diamond": Claim(
        "the paper's section III, nothing disturbs", 0.00012, (_SETTLED, _AS_THE_PAPER)
    ),
    "tree": Claim("seven boats of three sizes, two behind each leader", 0.0005, map_s=100.0),
    "straight": Claim("the leader sails straight on", 0.0025),
    "current": Claim("a current of 0.1 m/s across", 0.04, map_s=100.0),
    "weak_link": Claim("leaders heard at 5 Hz, 0.2 s late, 30 % lost, clocks apart", 0.035),
    "mismatch": Claim(
        "the boats' six parameters wrong by up to 50 %, white noise forces",
        0.10,
        (_EFFORT,),
        map_s=100.0,
        many_seeds=True,
    ),
    "noisy": Claim("a noisy own state at 20 Hz", 0.03, (_SMOOTH,)),
    "limits": Claim(
        "weak, slow propellers, start 20 m away", 0.0013, (_overshoot(0.002),), map_s=150.0
    ),
    "turning": Claim(
        "slots that turn with a leader on a circle", 0.025, (_overshoot(0.08),), map_s=150.0
    ),
    "stop_and_go": Claim(
        "the leader stops for 60 s, then goes on",
        0.00012,
        (_overshoot(0.025), _NO_CIRCLE),
        map_s=300.0,
    ),
    "sea": Claim("a hull that the law does not model, waves, current, gusts", 0.15, map_s=100.0),
}
