# SPDX-License-Identifier: MIT
"""Fleets drawn at random: trees of up to 12 boats, their rates, delays and losses.

    python -m tests.loop.random_trees --runs 1000

prints how they end: in their slots, held, or, which must not be, driven astray or spinning.
"""

import argparse
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from rich.progress import track

from sil import metrics, scenario
from sil.scenario import Scenario
from sil.world import Run, sail

MOST_BOATS, DURATION_S = 12, 120
IN_SLOT_M, ASTRAY_M = 0.2, 1.0
LAW_R_MAX = 0.8  # rad/s, the firmware's default
TOGETHER = 20


@dataclass(frozen=True)
class End:
    """Of a run's last 10 s: boats that stopped; of the others the farthest and the fastest turn."""

    held: int
    off_m: float
    yaw_rate: float  # rad/s

    @property
    def word(self) -> str:
        if self.off_m > ASTRAY_M:
            return "driven astray"
        if self.yaw_rate > LAW_R_MAX:
            return "spinning"
        if self.held:
            return "some boat held"
        return (
            "all in their slots" if self.off_m <= IN_SLOT_M else "all in FORMATION, not yet there"
        )


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
        while True:  # nobody's place is another's
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


def end_of(run: Run) -> End:
    """Who stopped has no thrust."""
    last = run.trace["t_s"] > run.trace["t_s"][-1] - 10.0
    driven = run.trace["thrust"][last].any(axis=(0, 2))
    off_m = metrics.distances(run.trace["error"])[last].max(axis=0)
    turn = np.abs(run.trace["nu"][last, 1:, 2]).max(axis=0)
    count = int(np.count_nonzero(~driven))
    return End(count, *(float(each[driven].max(initial=0.0)) for each in (off_m, turn)))


def ends(numbers: range, folder: Path) -> dict[int, End | str]:
    """Of each run how it ended, or why it was not sailed."""
    runs = sail([draw(number, folder) for number in numbers], {})
    return {
        number: end_of(run) if isinstance(run, Run) else str(run)
        for number, run in zip(numbers, runs, strict=True)
    }


def main() -> None:
    """Print how many ended in each way, and the worst runs of each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=1000)
    runs = parser.parse_args().runs
    found: dict[int, End | str] = {}
    with TemporaryDirectory() as folder:
        for begin in track(range(0, runs, TOGETHER)):
            found |= ends(range(begin, min(begin + TOGETHER, runs)), Path(folder))
    words = {n: end.word if isinstance(end, End) else "not sailed" for n, end in found.items()}
    for word, count in Counter(words.values()).most_common():
        print(f"{count:6} {word}")
        for number in [n for n, other in words.items() if other == word][:3]:
            print(f"         run {number}: {found[number]}")


if __name__ == "__main__":
    main()
