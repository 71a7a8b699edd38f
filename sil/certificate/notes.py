# SPDX-License-Identifier: MIT
"""Notes on a certificate: effects that it leaves out, and effects that it need not cover."""

import math
from collections.abc import Iterable

from sil.certificate.certificate import Certificate
from sil.certificate.rehanging import rehangings

SMALL_M = 0.2
LATE_S = 0.1  # delay of the navigation unit in the note, s
_NOT_LINEARISED = ("THR_SLEW", "THR_DEAD")


def notes(certificate: Certificate) -> list[str]:
    """The effects left out, and those that need not be covered."""
    scenario = certificate.scenario
    texts = [
        "The small-gain test is sufficient only: failing it proves nothing. It and the nominal "
        "loop (24) concern the paper's law; the sampled loop is that of the firmware, extensions "
        "included.",
        "Links: while no vessel is near (FS_SEP_M) and the leader waits for nobody (WP_WAIT_S), no "
        "boat influences its leader. Then late, rare or lost messages of a leader are outside "
        "every feedback loop: they add delay states, but change no multiplier. "
        "The gains of the chain show how they amplify motions from boat to boat, for small "
        "motions on a straight course. The rate of a boat's own fixes is in the loop.",
        "The verdict concerns small errors, and each boat's decay is that behind a leader without "
        "error. Along a chain the modes repeat: the k-th boat's error may follow t^(k-1) e^(-σt), "
        "so its decay begins later, although its final rate is the same.",
    ]
    texts += _depth(certificate)
    texts += _rehung(certificate)
    texts += _late(certificate)
    texts += _left_out(certificate)
    weather = scenario.wind.gust_mps or any(scenario.wind.mean_mps) or scenario.waves.height_m
    if weather or scenario.white_noise.power or scenario.navigation.noise.sigma.any():
        texts.append("Wind, waves and noise are left out.")
    return texts


def _depth(certificate: Certificate) -> Iterable[str]:
    if certificate.depth:
        yield (
            f"FORM_DEPTH,{certificate.depth}: with this parameter a boat warns when it is armed "
            "deeper in the tree of leaders than this certificate reaches. certificate.param and "
            "certificate.params have it for ground stations and flotillad --param-file."
        )


def _rehung(certificate: Certificate) -> Iterable[str]:
    found = rehangings(certificate.scenario)
    if found.before < 2:
        return
    covers = "every one" if found.after <= found.before else "not every one"
    text = (
        f"When any one boat fails, its followers follow another, and the longest line then "
        f"has at most {found.after} boats (now {found.before}): this certificate covers "
        f"{covers} of those trees"
    )
    decays = [case.sampled.decay for leg in certificate.legs for case in leg.cases]
    if found.step_m > SMALL_M and min(decays, default=0.0) > 0.0:
        after_s = math.log(found.step_m / SMALL_M) / min(decays)
        text += (
            f". A new leader moves all slots by {found.step_m:.1f} m. At the decay rate of small "
            f"errors, {SMALL_M:g} m of it remain after {after_s:.0f} s; the "
            f"limit LAW_U_MAX makes it take longer"
        )
    yield text + "."


def _late(certificate: Certificate) -> Iterable[str]:
    scenario = certificate.scenario
    delay_s = max((scenario.boat_unit(boat).delay_s for boat in scenario.boat), default=0.0)
    if delay_s > LATE_S:
        yield (
            f"The navigation unit is {delay_s:.2f} s late: the chain includes this delay, but "
            f"the sampled loop and its decay do not. Simulate it: flotilla run."
        )


def _left_out(certificate: Certificate) -> Iterable[str]:
    every = [case.setup.parameters for leg in certificate.legs for case in leg.cases]
    values = {name: sorted({own[name] for own in every} - {0.0}) for name in _NOT_LINEARISED}
    told = [f"{name} = {listed(of)}" for name, of in values.items() if of]
    if told:
        yield f"{', '.join(told)}: not in the linearised loop, where each counts as 0."


def listed(values: Iterable[float]) -> str:
    """The numbers, separated by commas."""
    return ", ".join(f"{value:g}" for value in values)
