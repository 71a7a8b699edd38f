# SPDX-License-Identifier: MIT
"""Fleets drawn at random: trees of up to 12 boats, their rates, delays and losses.

    python -m tests.loop.random_trees --runs 1000

prints how they end: in their slots, held, or, which must not be, driven astray or spinning; how
many of them the certificate passes, and how many of those end in their slots; and how the draws of
the two Monte Carlos end with the product's law.

Of the certificate it takes the parts in which draws differ: a boat's sampled loop, for each rate of
the navigation unit; and the depth to which a chain is certified, once for all draws with the same
rates, for the deepest of their trees and a radio no better than any of theirs: delay and loss are
rounded up to ROUNDED.
"""

import argparse
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from rich.progress import track

from sil.campaign.sampling import Sampler
from sil.certificate.certified_fleet import fleet, parameters
from sil.certificate.chain import chain
from sil.certificate.probe import deepest
from sil.certificate.references import references
from sil.certificate.sampled import sampled_loop
from sil.certificate.thrust import thrust_need
from sil.lockstep import metrics
from sil.lockstep.start import RunError
from sil.lockstep.world import Run, sail
from sil.results.claims import PRODUCT
from sil.scenario import scenario
from sil.scenario.scenario import Scenario

MOST_BOATS, DURATION_S = 12, 120
IN_SLOT_M, ASTRAY_M = 0.2, 1.0
LAW_R_MAX = 0.8  # rad/s, the firmware's default
TOGETHER = 20
ROUNDED = 0.15  # s of delay, share of loss
WANTED = 0.95  # of the certified
MONTE_CARLOS, MONTE_CARLO_RUNS = ("paper_monte_carlo", "monte_carlo"), 100
IN_SLOTS = "all in their slots"


@dataclass(frozen=True)
class End:
    """Of a run's last 10 s: number of boats held; of the others, greatest distance and yaw rate.

    With white noise on the hulls, yaw rates are means over a second.
    """

    held: int
    off_m: float
    yaw_rate: float  # rad/s

    def __str__(self) -> str:
        return f"{self.off_m:.2f} m off, {self.yaw_rate:.2f} rad/s, {self.held} held"

    @property
    def word(self) -> str:
        if self.off_m > ASTRAY_M:
            return "driven astray"
        if self.yaw_rate > LAW_R_MAX:
            return "spinning"
        if self.held:
            return "some boat held"
        return IN_SLOTS if self.off_m <= IN_SLOT_M else "all in FORMATION, not yet there"


def draw(number: int, folder: Path) -> Scenario:
    """Run `number`: boats 2 to 4 m astern and to a side of their leaders, starting near there."""
    rng = np.random.default_rng(number)
    place = {0: np.zeros(2)}
    text = (
        f'base = "diamond"\nlaw = "product"\nduration_s = {DURATION_S}\nseed = {number}\n'
        f"[navigation]\nrate_hz = {rng.choice([2.0, 5.0, 10.0, 20.0])}\nposition_noise_m = 0.02\n"
        "heading_noise_rad = 0.0087\nvelocity_noise_mps = 0.02\nyaw_rate_noise_radps = 0.0035\n"
        f"[link]\ndelay_s = {rng.uniform(0, 0.3):.3f}\nloss = {rng.uniform(0, 0.3):.3f}\n"
        f"everyone = {str(bool(rng.integers(2))).lower()}\n"
        "[clocks]\noffset_s = 10800.0\ndrift_ppm = 20.0\n"
        f"[parameters]\nSR_STATE = {rng.choice([2.0, 5.0, 10.0, 20.0])}\nTHR_SLEW = 5.0\n"
        "FS_LEADER_S = 3.0\n"
    )
    for boat in range(1, 1 + int(rng.integers(1, MOST_BOATS + 1))):
        leader = 0 if boat == 1 else int(rng.integers(max(1, boat - 4), boat))
        while True:  # no two boats share a slot
            offset = np.array([-rng.uniform(2.0, 4.0), rng.uniform(-3.0, 3.0)]) * (boat > 1)
            here = place[leader] + offset
            if all(np.hypot(*(here - there)) > 1.5 for there in list(place.values())[1:]):
                break
        place[boat] = here
        north, east = here + rng.normal(0.0, 0.5, 2)
        text += f"[[boat]]\nfollows = {leader}\noffset_m = [{offset[0]:.2f}, {offset[1]:.2f}]\n"
        text += f"eta = [{north:.2f}, {east:.2f}, {rng.normal(0.5, 0.3):.2f}]\n"
    path = folder / f"tree{number}.toml"
    path.write_text(text, encoding="utf-8")
    return scenario.load(path)


def end_of(run: Run, one: Scenario) -> End:
    """Classify a run's end; a boat without thrust in the last 10 s counts as held."""
    last = run.trace["t_s"] > run.trace["t_s"][-1] - 10.0
    driven = run.trace["thrust"][last].any(axis=(0, 2))
    off_m = metrics.distances(run.trace["error"])[last].max(axis=0)
    ticks = round(one.rate_hz) if one.white_noise.power else 1
    turned = np.cumsum(run.trace["nu"][last, 1:, 2], axis=0)
    turn = np.abs(turned[ticks:] - turned[:-ticks]).max(axis=0) / ticks
    count = int(np.count_nonzero(~driven))
    return End(count, *(float(each[driven].max(initial=0.0)) for each in (off_m, turn)))


def ends(drawn: Mapping[int, Scenario]) -> dict[int, End | str]:
    """The end of each run, or why it was not sailed."""
    found: dict[int, End | str] = {}
    numbers = list(drawn)
    for begin in track(range(0, len(numbers), TOGETHER), "sailing", transient=True):
        some = numbers[begin : begin + TOGETHER]
        for number, run in zip(some, sail([drawn[n] for n in some], {}), strict=True):
            found[number] = end_of(run, drawn[number]) if isinstance(run, Run) else str(run)
    return found


def certified(drawn: Mapping[int, Scenario]) -> set[int]:
    """The runs that the certificate passes."""
    cells = defaultdict(list)
    for number, one in drawn.items():
        rates = one.navigation.rate_hz, one.parameters["SR_STATE"], one.link.everyone
        radio = ceil(one.link.delay_s / ROUNDED), ceil(one.link.loss / ROUNDED)
        cells[rates, radio].append(number)
    one_of_each = {one.navigation.rate_hz: one for one in drawn.values()}
    holds = {rate_hz: loops_hold(one) for rate_hz, one in one_of_each.items()}
    passed: set[int] = set()
    for (_, (delay, loss)), numbers in track(cells.items(), "certifying", transient=True):
        longest = max((drawn[n] for n in numbers), key=lambda one: len(deepest(one)))
        worst = {"delay_s": ROUNDED * delay, "loss": ROUNDED * loss}
        link = longest.link.model_copy(update=worst)
        depth = certified_depth(longest.model_copy(update={"link": link}))
        if holds[longest.navigation.rate_hz]:
            passed |= {n for n in numbers if len(deepest(drawn[n])) <= depth}
    return passed


def certified_depth(one: Scenario) -> int:
    """The certified depth for its longest chain; a single boat is not a chain."""
    path = deepest(one)
    if len(path) < 2:
        return 1
    try:
        return min(chain(one, each, {}, most=len(path)).certified for each in references(one))
    except RunError:
        return 0


def loops_hold(one: Scenario) -> bool:
    """Whether every boat's sampled loop converges and its propellers suffice for its slot."""
    for reference in references(one):
        for _, slot, boat in fleet(one, reference, parameters(one, {})):
            loop, _ = sampled_loop(boat, reference.kind == "rest")
            converges = loop.steady and loop.outcome == "converges"
            if not (converges and thrust_need(slot, boat.propellers).given):
                return False
    return True


def tell(about: str, found: Mapping[int, End | str]) -> None:
    """Print how many ended in each way, the first three of each, and the fastest turn."""
    words = {n: end.word if isinstance(end, End) else "not sailed" for n, end in found.items()}
    print(f"{len(found)} {about}")
    for word, count in Counter(words.values()).most_common():
        print(f"{count:6} {word}")
        if word != IN_SLOTS:
            for number in [n for n, other in words.items() if other == word][:3]:
                print(f"         run {number}: {found[number]}")
    fastest = max(end.yaw_rate for end in found.values() if isinstance(end, End))
    print(f"       fastest turn in the last 10 s: {fastest:.2f} rad/s (LAW_R_MAX {LAW_R_MAX:g})")


def main() -> None:
    """Sail trees and Monte Carlos, certify the trees, print how they end."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=1000)
    runs = parser.parse_args().runs
    with TemporaryDirectory() as folder:
        drawn = {number: draw(number, Path(folder)) for number in range(runs)}
    found = ends(drawn)
    tell("random trees", found)
    passed = certified(drawn)
    print(f"       {told(passed, found)}; not certified: {runs - len(passed)}")
    for name in MONTE_CARLOS:
        sampler = Sampler(scenario.read(name, law_override=PRODUCT))
        some = {number: sampler.scenario(number) for number in range(MONTE_CARLO_RUNS)}
        tell(f"draws of {name}, product's law, turns as means over 1 s", ends(some))


def told(passed: set[int], found: Mapping[int, End | str]) -> str:
    """How many are certified, and the share of them that ends in its slots."""
    share = f", {100.0 * in_slots(passed, found):.1f} % of them" if passed else ""
    return (
        f"certified: {len(passed)}{share} in FORMATION within {IN_SLOT_M:g} m "
        f"(wanted: {100.0 * WANTED:g} %)"
    )


def in_slots(passed: set[int], found: Mapping[int, End | str]) -> float:
    """The share of the certified runs whose boats all end in their slots."""
    ended = [found[number] for number in passed]
    return sum(isinstance(end, End) and end.word == IN_SLOTS for end in ended) / len(ended)


if __name__ == "__main__":
    main()
