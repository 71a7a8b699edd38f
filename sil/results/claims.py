# SPDX-License-Identifier: MIT
"""The claims about the law: scenarios, and the bounds that their runs' figures must meet."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from sil.report import figures
from sil.report.figures import Trace
from sil.scenario.law import Law

BASELINE: Law = "paper"
PRODUCT: Law = "product"
LAWS = (BASELINE, PRODUCT)

# The firmware's defaults, and a navigation unit as users have it: these override a scenario that is
# sailed with the product's law. The paper has neither slew limit nor rates: its law sails the file
# unchanged.
_UNIT = "navigation.rate_hz=10.0"
_STATE = "parameters.SR_STATE=10.0"
_SLEW = "parameters.THR_SLEW=5.0"
_THRUST = (
    "propellers.forward_max_N=20.0",
    "propellers.reverse_max_N=20.0",
    "parameters.THR_FWD_MAX=20.0",
    "parameters.THR_REV_MAX=20.0",
)
_RATES = (_UNIT, _STATE, _SLEW)
DEFAULTS = (*_RATES, *_THRUST)


@dataclass(frozen=True)
class Bound:
    """A figure of a run and its bound.

    `key` names it in results.json; `what` and `unit` name it in tables. `reached` judges the
    baseline's and the product's figure, in this order; infinite and NaN figures miss any bound.
    Without `to_reach` the figure is printed for comparison only.
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
    """A scenario in a few words and its bounds; the first, `limit_m`, is the distance to the slot.

    `limit_m` is infinite if boats cannot hold their slots and must stop. `map_s`: part of the run
    that its map shows. `many_seeds`: figures are 95th percentiles. `defaults`: overrides with the
    product's defaults for its law, except the settings under test.
    """

    about: str
    limit_m: float
    others: tuple[Bound, ...] = ()
    map_s: float = 60.0
    many_seeds: bool = False
    defaults: tuple[str, ...] = DEFAULTS

    def settings(self, law: Law) -> tuple[str, ...]:
        """Overrides of the scenario for a run with `law`."""
        return self.defaults if law == PRODUCT else ()

    @property
    def bounds(self) -> tuple[Bound, ...]:
        """All bounds; the bound on the distance from the slot comes first."""
        what = "RMS distance from the slot, last third"
        return (_at_most(self.limit_m, "rms_error_m", what, "m", figures.rms_error_m), *self.others)


def _at_most(
    limit: float, key: str, what: str, unit: str, figure: Callable[[Trace], float]
) -> Bound:
    to_reach = f"{limit:g} {unit}" if math.isfinite(limit) else ""
    return Bound(key, what, unit, figure, to_reach, lambda _, own: own <= limit)


def _of_the_root(key: str, unit: str, figure: Callable[[Trace], float]) -> Bound:
    return Bound(f"roots_{key}", "the root's", unit, figure, "", lambda *_: True)


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
_APART = Bound(
    "least_separation_m",
    "smallest distance between two boats from 100 s on",
    "m",
    figures.least_separation_m,
    "at least 0.5 m",
    lambda _, own: 0.5 <= own < math.inf,
)
_DRIVEN_ASTRAY = Bound(
    "driven_astray",
    "boats over 1 m off their slots that are driven, last third",
    "boats",
    figures.driven_astray,
    "none",
    lambda _, own: own < 0.5,
)
_NO_CIRCLE = _at_most(
    0.15,
    "turns_at_a_stop",
    "heading swept while the leader is stopped; a circle is 1",
    "turn",
    figures.turns_at_a_stop,
)


_LATE = "from 100 s on"
_GROWTH = replace(
    _at_most(
        1.2,
        "yaw_rate_growth",
        f"largest yaw rate {_LATE}: the last boat's over boat 2's",
        "×",
        figures.yaw_rate_growth,
    ),
    laws=(PRODUCT,),  # with the paper's law the last boats lose their leaders
)


def _calm(yaw_rate_radps: float, speed_mps: float) -> tuple[Bound, ...]:
    """Bounds on a boat's largest yaw rate and speed, compared with the root's."""
    return (
        _at_most(
            yaw_rate_radps,
            "yaw_rate_radps",
            f"largest yaw rate {_LATE}",
            "rad/s",
            figures.largest_yaw_rate_radps,
        ),
        _of_the_root("yaw_rate_radps", "rad/s", figures.roots_yaw_rate_radps),
        _at_most(
            speed_mps, "speed_mps", f"largest speed {_LATE}", "m/s", figures.largest_speed_mps
        ),
        _of_the_root("speed_mps", "m/s", figures.roots_speed_mps),
    )


# 1.15 × the root's 0.35 rad/s and 0.58 m/s; LAW_R_MAX and LAW_U_MAX
_AS_THE_ROOT, _WITHIN_THE_CAPS = _calm(0.4, 0.67), _calm(0.8, 1.5)
_FOR_COMPARISON = replace(_GROWTH, to_reach="", reached=lambda *_: True)


def _overshoot(limit_m: float) -> Bound:
    what = "overshoot: how far from the slot again, once within 2 m of it"
    return _at_most(limit_m, "overshoot_m", what, "m", figures.overshoot_m)


# Bounds are about twice the measured figures, or requirements.
CLAIMS = {
    "diamond": Claim("the paper's section III, nothing disturbs", 0.002, (_SETTLED, _AS_THE_PAPER)),
    "tree": Claim("seven boats of three sizes, two behind each leader", 0.002, map_s=100.0),
    "straight": Claim("the leader sails straight on", 0.0025),
    "current": Claim("a current of 0.1 m/s across", 0.04, map_s=100.0),
    "weak_link": Claim(
        "leaders heard at 5 Hz, 0.2 s late, 30 % lost, clocks apart",
        0.035,
        defaults=(_UNIT, _SLEW, *_THRUST),
    ),
    "mismatch": Claim(
        "the boats' six parameters wrong by up to 50 %, white noise forces",
        0.10,
        (_EFFORT,),
        map_s=100.0,
        many_seeds=True,
    ),
    "noisy": Claim(
        "a noisy own state at 20 Hz", 0.03, (_SMOOTH,), defaults=(_STATE, _SLEW, *_THRUST)
    ),
    "late_unit": Claim(
        "the same, from units that are 0.2 s late, which the boats do not know",
        0.03,
        _AS_THE_ROOT[:2],
        defaults=(_STATE, _SLEW, *_THRUST),
    ),
    "limits": Claim(
        "weak, slow propellers, start 20 m away",
        0.003,
        (_overshoot(0.0035),),
        map_s=150.0,
        defaults=_RATES,
    ),
    "turning": Claim(
        "slots that turn with a leader on a circle", 0.025, (_overshoot(0.35),), map_s=150.0
    ),
    "diamond_frame1": Claim(
        "`diamond`'s slots turn with each leader: inner ones would go astern",
        math.inf,
        (_DRIVEN_ASTRAY, _APART),
        map_s=100.0,
    ),
    "stop_and_go": Claim(
        "the leader stops for 60 s, then goes on",
        0.002,
        (_overshoot(0.1), _NO_CIRCLE),
        map_s=300.0,
    ),
    "resting_leader": Claim(
        "a leader that never moves, boats 10 m abeam of it", 0.4, defaults=_THRUST
    ),
    "sea": Claim(
        "a hull that the law does not model, waves, current, gusts",
        0.15,
        map_s=100.0,
        defaults=_RATES,
    ),
    "tail_wind": Claim(
        "the same hull at 0.4 m/s before 12 m/s of wind", 0.03, map_s=100.0, defaults=()
    ),
    "line10": Claim(
        "ten boats in line ahead, a noisy own state, all hear all, 0.2 s late",
        0.02,
        (*_AS_THE_ROOT, _GROWTH),
        map_s=100.0,
        defaults=_THRUST,
    ),
    "line20": Claim(
        "twenty of them", 0.02, (*_AS_THE_ROOT, _GROWTH), map_s=100.0, defaults=_THRUST
    ),
    "line20_relay": Claim(
        "each of the twenty hears its neighbours only",
        0.15,
        (*_WITHIN_THE_CAPS, _FOR_COMPARISON),
        map_s=100.0,
        defaults=_THRUST,
    ),
    "star20": Claim(
        "all of the twenty behind the first", 0.02, _AS_THE_ROOT, map_s=100.0, defaults=_THRUST
    ),
}
