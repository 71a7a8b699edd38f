# SPDX-License-Identifier: MIT
"""The verdict in one sentence, and its criterion."""

import math
from collections.abc import Iterator

import flotilla

from sil.certificate.certificate import Case, Certificate, Leg
from sil.certificate.chain import Chain, too_deep
from sil.certificate.sampled import Misled
from sil.lockstep.metrics import SETTLED_M

_LEAST = 0.001  # m, N: smaller effects are reported as this value
_TEN_TIMES = -9.0  # margin below which a percentage means nothing to a reader
_IN_SLOT_M = 0.2  # least limit of the permanent distance; a boat's own is FS_SLOT_M / 5, if more


def holds(certificate: Certificate) -> bool:
    """Whether all boats converge to their slots, their thrusts suffice, and the chains hold."""
    return next(_failures(certificate), None) is None


def sentence(certificate: Certificate) -> str:
    """The verdict: the certified figures, or the gravest failure."""
    wrong = next(_failures(certificate), None)
    if wrong is not None:
        return f"not certified: {wrong}"
    cases = [(leg, case) for leg in certificate.legs for case in leg.cases]
    slowest = min((case for _, case in cases), key=lambda case: case.sampled.decay)
    margin = min(case.thrust.margin for _, case in cases)
    text = (
        f"certified about the formation: in every boat's sampled loop small errors decay by at "
        f"least {slowest.sampled.decay:.3f} 1/s, and {100.0 * margin:.0f} % of the propellers' "
        f"limits is left"
    )
    chains = [leg.chain for leg in certificate.legs if isinstance(leg.chain, Chain)]
    if chains:
        text += f"; chains examined: {' and '.join(name(path) for path in chains[0].examined)}"
    neutral = [case for _, case in cases if case.sampled.neutral]
    if neutral:
        text += "; while the leader is at rest, errors abeam stay as they are" + _up_to(neutral)
    misled = [case.sampled.misled for _, case in cases if case.sampled.misled]
    if misled:
        text += f"; {_misled(misled)}"
    worst = max((case for _, case in cases), key=_off_m)
    if _off_m(worst) > SETTLED_M:
        text += f"; but {name(worst.boats)}: {_off_m(worst):.2f} m off the slot permanently"
    return text


def _failures(certificate: Certificate) -> Iterator[str]:
    """Sentences on all failures, the gravest first."""
    cases = [(leg, case) for leg in certificate.legs for case in leg.cases]
    where = len(certificate.legs) > 1
    for leg, case in cases:
        if not case.thrust.given:
            yield _thrust(case) + _leg(leg, where)
    for leg, case in cases:
        if case.sampled.outcome == "grows":
            rate = -case.sampled.decay
            yield f"{name(case.boats)}: small errors grow by {rate:.3g} 1/s" + _leg(leg, where)
    for leg, case in cases:
        if case.sampled.outcome == "stays":
            yield f"{name(case.boats)}: some error never decays{_why(leg, case)}" + _leg(leg, where)
    for leg, case in cases:
        wrong = case.sampled.misled
        if wrong and (wrong.limited or not _off_m(case) + wrong.off_m <= _in_slot_m(leg, case)):
            yield f"{name(case.boats)}: {_misled([wrong])}" + _leg(leg, where)
    for leg, case in cases:
        if not case.sampled.steady:
            limit = ", a propeller at its limit" if case.sampled.limited else ""
            off = f"{_off_m(case):.2g} m off its slot"
            yield f"{name(case.boats)}: no steady regime, {off}{limit}" + _leg(leg, where)
    for leg, case in cases:
        limit_m = _in_slot_m(leg, case)
        if not _off_m(case) <= limit_m:
            off = f"{_off_m(case):.2f} m off the slot permanently, over {limit_m:.2g} m"
            yield f"{name(case.boats)}: {off}" + _leg(leg, where)
    yield from _chain_failures(certificate.legs)


def _chain_failures(legs: list[Leg]) -> Iterator[str]:
    where = len(legs) > 1
    for leg in legs:
        if isinstance(leg.chain, str):
            yield f"a chain of boats cannot be sailed: {leg.chain}" + _leg(leg, where)
        elif leg.chain is not None and not leg.chain.holds:
            yield too_deep(leg.chain) + _leg(leg, where)


def _up_to(cases: list[Case]) -> str:
    """Limit of the errors abeam that persist: boats farther off approach (core/approach.hpp)."""
    every = [case.setup.parameters for case in cases]
    if any(own["LAW_XT_DIST"] * own["LAW_KX"] == 0.0 for own in every):
        return ""
    return f" up to {1.5 * max(own['LAW_XT_DIST'] for own in every):g} m"


def _misled(every: list[Misled]) -> str:
    """The effect of the current along straight legs, which is not observable there."""
    wrong_mps, off_m, thrust_N = (
        max(getattr(one, name) for one in every) for name in ("wrong_mps", "off_m", "thrust_N")
    )
    limit = ", a propeller at its limit" if any(one.limited for one in every) else ""
    return (
        "the current along a straight leg is not measured, and an error of its estimate stays "
        f"until the next turn: {wrong_mps:.2g} m/s of it moves a boat by at most "
        f"{max(off_m, _LEAST):.2g} m and changes a thrust by at most "
        f"{max(thrust_N, _LEAST):.2g} N{limit}"
    )


def _off_m(case: Case) -> float:
    """Mean horizontal distance from the slot over the last window, m."""
    return math.hypot(*case.sampled.error[:2])


def _in_slot_m(leg: Leg, case: Case) -> float:
    """The distance within which a boat is in its slot, m (core/station.hpp)."""
    own = case.setup.parameters
    slot_m = own["FS_SLOT_M"] or flotilla.derived()["FS_SLOT_M"]  # as for the limits of a chain
    at_rest = 1.6 * own["LAW_XT_DIST"] if leg.reference.kind == "rest" else 0.0
    return max(_IN_SLOT_M, 0.2 * slot_m, at_rest)


def name(boats: list[int]) -> str:
    """The boats' names as text."""
    if len(boats) == 1:
        return f"boat {boats[0]}"
    if boats == list(range(boats[0], boats[-1] + 1)):
        return f"boats {boats[0]}–{boats[-1]}"
    return f"boats {', '.join(map(str, boats))}"


def _thrust(case: Case) -> str:
    need = case.thrust
    if need.margin >= 0.0:
        return (
            f"{name(case.boats)}: the slot needs {need.sway_N:.2g} N in sway, "
            "which no propeller can give"
        )
    side = "port" if need.side == "port" else "starboard"
    if need.margin == -math.inf:
        return (
            f"{name(case.boats)}: the slot needs reverse thrust, but the {side} propeller has none"
        )
    if need.margin < _TEN_TIMES:
        return (
            f"{name(case.boats)}: the slot needs more than ten times the {need.direction} thrust "
            f"that the {side} propeller can give"
        )
    return (
        f"{name(case.boats)}: the slot needs {-100.0 * need.margin:.0f} % more {need.direction} "
        f"thrust than the {side} propeller can give"
    )


def _why(leg: Leg, case: Case) -> str:
    mode = next(iter(case.sampled.slowest), "")
    if mode.startswith(("current", "unknown")):
        return f", due to a wrong estimate of the {mode}, which is not observable on this leg"
    if leg.reference.mu > 0.0 or case.setup.parameters.get("LAW_XT_DIST", 0.0) > 0.0:
        return ""
    return ", because the leader does not turn and LAW_XT_DIST is 0"


def _leg(leg: Leg, told: bool) -> str:
    if not told:
        return ""
    return f" on the leg from {', '.join(f'{t:g}' for t in leg.from_s)} s"
