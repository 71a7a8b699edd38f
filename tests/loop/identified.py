# SPDX-License-Identifier: MIT
"""Hulls that measure themselves: voyages of varied hulls, identified, beside the truth.

    python -m tests.loop.identified [--hulls N] [--first SEED] [--only KIND] [--no-fleets]

Sails N hulls (20), by their seeds from the first one on, of each kind in sil/hulls, every number up
to 30 % off and the propellers up to 10 % apart, in 0.1 m/s of current and 3 m/s of wind with gusts;
each with an RTK unit and with a GPS of 0.5 m. The boats know the numbers of the kind, not their
own. Prints a line for each voyage as it ends, then a table; where it is interrupted, the table of
what there is. Errors: of drag at 0.5 and 1 m/s, of the yaw moment at 0.1 and 0.3 rad/s, of m22 and
m33 over m11; then gain difference of the propellers and the sum of lag and dead time; R² over 10 s
in open loop, fitted to every other minute, scored on the rest. Then four such boats sail in a
diamond behind an S-curve, with the parameters that were found and no other: RMS distance from the
slots in calm water with exact states and in the weather of `sea` with the noise of `noisy`; of
every fifth hull, as it takes minutes, the certificate. Voyages alone, without fleets, take a third
of the time.
"""

import argparse
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from rich.progress import track

from sil.identify import vessel_numbers
from sil.identify.hull_terms import INDEX
from sil.identify.identification import Identification, identify
from sil.identify.log_files import read
from sil.identify.vessel_numbers import RATES_RADPS, SPEEDS_MPS
from sil.identify.voyage_log import SAMPLE_S, Array, BadLogError, VoyageLog
from sil.identify.voyage_model import Body
from sil.lockstep.start import RunError
from sil.lockstep.world import all_sailed, sail
from sil.logs import own_motion
from sil.plant.wind import AIR_KGPM3
from sil.scenario import presets, scenario
from sil.scenario.scenario import Scenario
from tests.loop import gains
from tests.loop.presets import BOATS, alike
from tests.loop.presets import WEATHER as NOISY

VARIED, APART = 0.3, 0.1
CERTIFIED = 5  # one of so many
WEATHER = (
    "water.current_mps=[0.07, 0.07]",
    "wind.mean_mps=[0.0, 3.0]",
    "wind.gust_mps=1.0",
)
_SEA = scenario.load("sea")
WATERS: dict[str, tuple[str, ...]] = {
    "calm": (),
    "weather": (*NOISY, *(f"waves.{key}={value!r}" for key, value in _SEA.waves)),
}
UNITS = {
    "RTK": (),
    "GPS": ("navigation.position_noise_m=0.3", "navigation.position_drift_m=0.4"),
}
_KEPT = {"length_m", "draft_m", "hull_y_m", "arm_m", "port_gain", "stbd_gain"}
_LENGTH_M = 1.3  # where a kind has none: BOAT_LEN's default


@dataclass(frozen=True)
class Found:
    """Errors of one hull: shares of the truth (drag, moment, m22, m33), then gain, s, R²."""

    kind: str
    unit: str
    seed: int
    shares: dict[str, float]
    gain: float
    late_s: float
    r2_u: float
    r2_r: float
    fleets: dict[str, gains.Found]
    certificate: str

    def worst(self) -> float:
        """The largest share."""
        return max(map(abs, self.shares.values()))

    def __str__(self) -> str:
        """One line of the survey."""
        parts = " ".join(f"{name} {share:+.1%}" for name, share in self.shares.items())
        return (
            f"{self.kind} {self.unit} {self.seed}: {parts}, gain {self.gain:+.1%}, "
            f"late {1e3 * self.late_s:+.0f} ms, R² {self.r2_u:.3f} {self.r2_r:.3f}, "
            f"{''.join(f'{water} {fleet.text} m, ' for water, fleet in self.fleets.items())}"
            f"certificate {self.certificate or 'not looked at'}"
        )


def changes(kind: str, seed: int) -> list[str]:
    """Overrides that vary a hull of a kind."""
    rng = np.random.default_rng([seed, sum(map(ord, kind))])
    hull = presets.load(kind)
    out = [f"hull={kind}", f"seed={seed}"]
    for part in ("vessel", "propellers"):
        for key, value in getattr(hull, part):
            if key in _KEPT:
                continue
            factor = rng.uniform(1.0 - VARIED, 1.0 + VARIED) if value else 1.0
            most = 1.0 if key == "expo" else np.inf
            out.append(f"{part}.{key}={float(min(value * factor, most))!r}")
    apart = float(rng.uniform(-APART, APART))
    return [
        *out,
        f"propellers.port_gain={1.0 - apart!r}",
        f"propellers.stbd_gain={1.0 + apart!r}",
    ]


def voyage(chosen: Scenario) -> VoyageLog:
    """Sail a voyage; its log, of what went over the wires. Raises RunError."""
    with tempfile.TemporaryDirectory() as folder:
        recording, rows = Path(folder, "recording.bin"), Path(folder, "voyage.csv")
        all_sailed(sail([chosen], {}, record=recording))
        own_motion.write(rows, own_motion.of_run(recording, 1))
        ((log,), _) = read([rows])
    return log


def sailed(kind: str, unit: str, seed: int) -> Scenario:
    """The voyage of a varied hull in the weather."""
    return scenario.load("voyage", [*changes(kind, seed), *WEATHER, *UNITS[unit]])


def body_of(chosen: Scenario) -> Body:
    """The lengths that an owner can measure with a tape."""
    return Body(chosen.propellers.arm_m, chosen.vessel.length_m or _LENGTH_M, SAMPLE_S)


def measured(task: tuple[str, str, int], waters: Sequence[str] = tuple(WATERS)) -> Found | str:
    """Sail a voyage and identify it; a sentence where either fails. waters: of the fleets."""
    kind, unit, seed = task
    chosen = sailed(kind, unit, seed)
    try:
        found = identify([voyage(chosen)], body_of(chosen), lambda _: None)
    except (RunError, BadLogError) as error:
        return f"{kind} {unit} {seed}: {error}"
    pair = chosen.propellers
    terms = found.fit.values
    gain = (pair.stbd_gain - pair.port_gain) / (pair.stbd_gain + pair.port_gain)
    scores = [score for score in found.held_out if score is not None]
    fleets = {water: fleet(kind, chosen, found, WATERS[water]) for water in waters}
    runs = sail(list(fleets.values()), {})
    return Found(
        kind,
        unit,
        seed,
        shares(terms, chosen),
        float(terms[INDEX["gain"]]) - gain,
        float(terms[INDEX["lag"]] + terms[INDEX["dead_time"]]) - pair.lag_s,
        min((score.u for score in scores), default=0.0),
        min((score.r for score in scores), default=0.0),
        {water: gains.found_of(run) for water, run in zip(fleets, runs, strict=True)},
        gains.certificate(fleets["calm"]) if waters and seed % CERTIFIED == 0 else "",
    )


def fleet(kind: str, chosen: Scenario, found: Identification, more: Sequence[str]) -> Scenario:
    """Four boats of the voyage's hull, whose firmware has the parameters that were found."""
    told = vessel_numbers.parameters(found, vessel_numbers.Boat(chosen.vessel.m11, added=0.0))
    own = [
        *(f"vessel.{key}={value!r}" for key, value in chosen.vessel),
        *(f"propellers.{key}={value!r}" for key, value in chosen.propellers),
        *(f"parameters.{name}={value!r}" for name, value in told.items()),
    ]
    changes = [f"boat.{boat}.{change}" for boat in range(1, BOATS + 1) for change in own]
    return scenario.load("mixed", [*alike(kind), *changes, *more])


def shares(terms: Array, chosen: Scenario) -> dict[str, float]:
    """Errors of a scenario's hull as shares of the truth."""
    truth, body = chosen.vessel.hull, body_of(chosen)
    m11 = truth.m11
    # A voyage determines only the sum of both drags.
    windage = chosen.vessel.windage
    air = 0.5 * AIR_KGPM3 * windage.frontal_m2 * windage.c_x
    x = truth.length_m * ((np.arange(400) + 0.5) / 400 - 0.5)
    out = {
        "m22": terms[INDEX["m22"]] / (truth.m22 / m11) - 1.0,
        "m33": terms[INDEX["m33"]] / (truth.m33 / m11) - 1.0,
    }
    for u in SPEEDS_MPS:
        true = (truth.d11 + (truth.d11_quadratic + air) * u) * u
        out[f"drag {u:g}"] = float(vessel_numbers.drag_N(terms, m11, u)) / true - 1.0
    for r in RATES_RADPS:
        strips = truth.crossflow * np.abs(x) ** 3 * r * r * truth.length_m / 400
        true = (truth.d33 + truth.d33_quadratic * r) * r + float(strips.sum())
        found = float(vessel_numbers.yaw_moment_Nm(terms, m11, r, body.length_m))
        out[f"yaw {r:g}"] = found / true - 1.0
    return {name: float(share) for name, share in out.items()}


def table(every: list[Found | str]) -> list[str]:
    """The table's lines: medians and 90th percentiles of the errors' sizes."""
    done = [one for one in every if isinstance(one, Found)]
    names = ["m22", "m33", *(f"drag {u:g}" for u in SPEEDS_MPS)]
    names += [f"yaw {r:g}" for r in RATES_RADPS]
    heads = [*names, "all within 10 % (RTK: 5 %)", "gain", "late, ms", "R² u", "R² r"]
    heads += ["calm, m", "weather, m", "certified"]
    lines = [
        f"| hulls | {' | '.join(heads)} |",
        f"|---|{'--:|' * len(heads)}",
    ]
    for kind, unit in sorted({(one.kind, one.unit) for one in done}):
        here = [one for one in done if (one.kind, one.unit) == (kind, unit)]
        cells = [_sizes([one.shares[name] for one in here]) for name in names]
        within = np.mean([one.worst() < (0.05 if unit == "RTK" else 0.1) for one in here])
        gain = _sizes([one.gain for one in here])
        late = np.quantile([abs(one.late_s) for one in here], 0.9)
        r2 = [np.quantile([getattr(one, name) for one in here], 0.1) for name in ("r2_u", "r2_r")]
        cells += [f"{within:.0%}", gain, f"{1e3 * late:.0f}", f"{r2[0]:.3f}", f"{r2[1]:.3f}"]
        cells += [_fleets([one.fleets[w] for one in here if w in one.fleets]) for w in WATERS]
        looked = [one.certificate for one in here if one.certificate]
        cells.append(f"{sum('holds' in one for one in looked)} of {len(looked)}")
        lines.append(f"| {kind}, {unit}, {len(here)} | {' | '.join(cells)} |")
    return lines + [one for one in every if isinstance(one, str)]


def _sizes(errors: list[float]) -> str:
    median, ninetieth = np.quantile(np.abs(errors), [0.5, 0.9])
    return f"{median:.1%}; {ninetieth:.1%}"


def _fleets(found: list[gains.Found]) -> str:
    kept = [one.rms_m for one in found if not one.left]
    left = f"; {len(found) - len(kept)} left FORMATION" if len(kept) < len(found) else ""
    return f"{np.median(kept):.3f}; {max(kept):.3f}{left}" if kept else f"0{left}"


def main() -> None:
    """Sail, identify, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hulls", type=int, default=20, help="of each kind (20)")
    parser.add_argument("--first", type=int, default=1, help="seed of the first one (1)")
    parser.add_argument("--workers", type=int, default=2, help="processes (2)")
    parser.add_argument("--only", help="one kind")
    parser.add_argument("--no-fleets", action="store_true", help="identify only")
    options = parser.parse_args()
    kinds = [options.only] if options.only else presets.names()
    tasks = [
        (kind, unit, seed)
        for seed in range(options.first, options.first + options.hulls)
        for kind in kinds
        for unit in UNITS
    ]
    waters = () if options.no_fleets else tuple(WATERS)
    every: list[Found | str] = []
    try:
        with ProcessPoolExecutor(options.workers) as pool:
            for one in track(
                pool.map(partial(measured, waters=waters), tasks), "identifying", len(tasks)
            ):
                every.append(one)
                print(one, flush=True)
    finally:
        print("\nMedian; 90th percentile of the errors' sizes:\n")
        print("\n".join(table(every)))


if __name__ == "__main__":
    main()
