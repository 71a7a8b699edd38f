# SPDX-License-Identifier: MIT
"""The certificate of a scenario: all references, all boats, all tests, and the verdict.

Boats whose loops are equal are examined once, and so are repeated inputs of the leader.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from sil.certificate import floquet, gains
from sil.certificate.certified_fleet import fleet, parameters, vessel_of
from sil.certificate.chain import Chain, chain
from sil.certificate.loop import Boat
from sil.certificate.margins import Margins, margins
from sil.certificate.monodromy import Points
from sil.certificate.probe import deepest
from sil.certificate.references import Reference, references
from sil.certificate.sampled import SampledLoop, sampled_loop
from sil.certificate.search import Search
from sil.certificate.slots import SlotMotion
from sil.certificate.small_gain import SmallGain, small_gain
from sil.certificate.thrust import ThrustNeed, thrust_need
from sil.lockstep.start import RunError
from sil.scenario.scenario import Scenario

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Floquet:
    """Multipliers of eq:26 over `period_s`, largest first, and the decay of the slowest, 1/s."""

    period_s: float
    multipliers: list[complex]
    decay: float


@dataclass(frozen=True)
class Case:
    """Equal boats behind one reference, and their results.

    `curve_*`: decay, 1/s, at `gains.CURVE_K_X`; empty if the leader is at rest.
    """

    boats: list[int]
    setup: Boat
    points: Points
    small_gain: SmallGain
    floquet: Floquet
    thrust: ThrustNeed
    sampled: SampledLoop
    curve_floquet: list[float]
    curve_sampled: list[float]
    curve_of_law: list[float]


@dataclass(frozen=True)
class Leg:
    """A reference, the times (s) at which it begins, and the boats behind it.

    `chain`: the worst line of boats that follow each other, or the reason why some probes could
    not be sailed; None if there is no such line, or if the leader is at rest.
    """

    reference: Reference
    from_s: list[float]
    cases: list[Case]
    chain: Chain | str | None
    margins: Margins | None


@dataclass(frozen=True)
class Certificate:
    """All results; `search` is None if it was not made, or if the leader never moves."""

    scenario: Scenario
    legs: list[Leg]
    search: Search | None

    @property
    def depth(self) -> int | None:
        """The depth to which every leg's chain is certified: FORM_DEPTH; None without chains."""
        chains = [leg.chain for leg in self.legs if leg.chain is not None]
        return min((0 if isinstance(one, str) else one.certified for one in chains), default=None)


def certify(
    scenario: Scenario,
    overrides: dict[str, float],
    progress: Progress,
    *,
    loops_only: bool = False,
) -> Certificate:
    """Examine a scenario; `overrides` go to every boat's firmware.

    `progress` is called with the current task and its completed share; `loops_only`: each boat's
    loop and thrust, without chains of boats and other gains, in seconds. ValueError for a parameter
    that the firmware refuses, or for a leader without a steady regime.
    """
    firmware = parameters(scenario, overrides)
    legs: list[Leg] = []
    progress("the leader's steady regime", 0.0)
    found = _different(references(scenario), any(scenario.water.current_mps))
    for number, (reference, from_s) in enumerate(found, start=1):
        cases = []
        for boats, slot, setup in fleet(scenario, reference, firmware):
            who = f"leg {number} of {len(found)}, boat {', '.join(map(str, boats))}"
            tell = None if loops_only else partial(progress, who)
            cases.append(_case(boats, reference, slot, setup, tell))
        if loops_only:
            legs.append(Leg(reference, from_s, cases, None, None))
            continue
        progress(f"leg {number} of {len(found)}, the chains of boats", 0.0)
        legs.append(Leg(reference, from_s, cases, *_chain(scenario, reference, overrides)))
    moving = [
        (c.setup, c.points) for leg in legs if leg.reference.kind != "rest" for c in leg.cases
    ]
    search = None
    if moving and not loops_only:
        search = gains.fastest(moving, partial(progress, "search for the gains"))
    return Certificate(scenario, legs, search)


def _chain(
    scenario: Scenario, reference: Reference, overrides: dict[str, float]
) -> tuple[Chain | str | None, Margins | None]:
    if reference.kind == "rest" or len(deepest(scenario)) < 2:
        return None, None
    try:
        found = chain(scenario, reference, overrides)
    except RunError as error:
        return str(error), None
    return found, margins(scenario, reference, overrides, found)


def _different(found: list[Reference], north_counts: bool) -> list[tuple[Reference, list[float]]]:
    """Each reference once, with the times at which it begins."""
    groups: list[tuple[Reference, list[float]]] = []
    for reference in found:
        for other, from_s in groups:
            if _alike(reference, other, north_counts):
                from_s.append(reference.from_s)
                break
        else:
            groups.append((reference, [reference.from_s]))
    return groups


def _alike(a: Reference, b: Reference, north_counts: bool) -> bool:
    own, other = (reference.input.model_dump(exclude={"from_s"}) for reference in (a, b))
    return own == other and not north_counts


def _case(
    boats: list[int], reference: Reference, slot: SlotMotion, setup: Boat, tell: gains.Tell | None
) -> Case:
    own = setup.parameters
    speeds_mps = np.abs(reference.motion.nu(reference.motion.times_s)[:, 0])
    vessel, at_rest = vessel_of(own, float(speeds_mps.mean())), reference.kind == "rest"
    values = floquet.multipliers(vessel, reference, [own["LAW_KX"], *gains.CURVE_K_X])
    decays = floquet.decay_rates(reference, values).tolist()
    sampled, points = sampled_loop(setup, at_rest)
    curve = [] if at_rest or tell is None else gains.curve(setup, points, tell)
    return Case(
        boats=boats,
        setup=setup,
        points=points,
        small_gain=small_gain(vessel, reference, own["LAW_KX"], own["LAW_KPSI"]),
        floquet=Floquet(floquet.period_s(reference), values[0].tolist(), decays[0]),
        thrust=thrust_need(slot, setup.propellers),
        sampled=sampled,
        curve_floquet=decays[1:] if curve else [],
        curve_sampled=[whole for whole, _ in curve],
        curve_of_law=[law for _, law in curve],
    )
