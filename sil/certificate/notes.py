# SPDX-License-Identifier: MIT
"""Notes on a certificate: effects that it leaves out, and those that it need not cover."""

import math
from collections.abc import Iterable

from sil.certificate.certificate import Certificate
from sil.certificate.rehanging import rehangings

SMALL_M = 0.2
_NOT_LINEARISED = ("THR_SLEW", "THR_DEAD")


def notes(certificate: Certificate) -> list[str]:
    """The effects left out, and those that need not be covered."""
    scenario = certificate.scenario
    texts = [
        "The small-gain test is sufficient only: not to pass it proves nothing. It and the nominal "
        "loop (24) are about the paper's law; the sampled loop is that of the firmware, extensions "
        "and all.",
        "Links: no boat acts on its leader, so that a late, rare or lost message of a leader is in "
        "no loop: it adds states of delay, no feedback, and moves no multiplier. How it amplifies "
        "motions from boat to boat is in the gains of the chain, which are those of small motions "
        "on a straight course. The own fixes' rate is in the loop.",
        "The verdict is about small errors, and each boat's decay is that behind a leader without "
        "error. Down a chain the modes repeat: the k-th boat's error may go as t^(k-1) e^(-σt), "
        "so that its decay, at the same rate in the end, begins later.",
    ]
    texts += _rehung(certificate)
    texts += _left_out(certificate)
    weather = scenario.wind.gust_mps or any(scenario.wind.mean_mps) or scenario.waves.height_m
    if weather or scenario.white_noise.power or scenario.navigation.noise.sigma.any():
        texts.append("Wind, waves and noise are left out.")
    return texts


def _rehung(certificate: Certificate) -> Iterable[str]:
    found = rehangings(certificate.scenario)
    if found.before < 2:
        return
    covers = "every one" if found.after <= found.before else "not every one"
    text = (
        f"When any one boat fails, its followers are hung on another, and the longest line then "
        f"has {found.after} boats at the most, now {found.before}: this certificate covers "
        f"{covers} of those trees"
    )
    decays = [case.sampled.decay for leg in certificate.legs for case in leg.cases]
    if found.step_m > SMALL_M and min(decays, default=0.0) > 0.0:
        after_s = math.log(found.step_m / SMALL_M) / min(decays)
        text += (
            f". A new leader moves all slots by {found.step_m:.1f} m. At the rate at which small "
            f"errors decay, {SMALL_M:g} m of it are left after {after_s:.0f} s; LAW_U_MAX makes "
            f"that later"
        )
    yield text + "."


def _left_out(certificate: Certificate) -> Iterable[str]:
    every = [case.setup.parameters for leg in certificate.legs for case in leg.cases]
    values = {name: sorted({own[name] for own in every} - {0.0}) for name in _NOT_LINEARISED}
    told = [f"{name} = {listed(of)}" for name, of in values.items() if of]
    if told:
        yield f"{', '.join(told)}: not in the linearised loop, which is examined as if 0."


def listed(values: Iterable[float]) -> str:
    """Numbers in words."""
    return ", ".join(f"{value:g}" for value in values)
