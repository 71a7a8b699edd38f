# SPDX-License-Identifier: MIT
"""Boats whose hull is not what their firmware was told: RMS distance from the slots, end state.

    python -m tests.loop.off_hull [HULL…] [--weather]

Four of each hull in sil/hulls in a diamond behind an S-curve at its cruise, as in
`tests.loop.presets`. One number of the boats' hulls, then all six, are half or twice as great as
in the firmware's parameters; a drag with its quadratic part: d11 with d11_quadratic, d22 with
crossflow_cd, d33 with d33_quadratic and d33_speed. Gains are derived, all else is the firmware's
default. `--weather`: in the wind, current and noise of `tests.loop.presets`.
"""

import argparse

from sil.lockstep.world import sail
from sil.scenario import presets, scenario
from sil.scenario.scenario import Scenario
from tests.loop.gains import Found, found_of
from tests.loop.presets import BOATS, WEATHER, alike

FACTORS = (0.5, 2.0)
#: Hull terms that are scaled together, by the firmware's name.
GROUPS = {
    "m11": ("m11",),
    "m22": ("m22",),
    "m33": ("m33",),
    "d11": ("d11", "d11_quadratic"),
    "d22": ("d22", "crossflow_cd"),
    "d33": ("d33", "d33_quadratic", "d33_speed"),
}
ALL = "all six"
CASES = tuple((number, factor) for number in (*GROUPS, ALL) for factor in FACTORS)

#: The worst cases of each hull, or nearly: every run of the tests sails them.
SHORT = (("m11", 0.5), ("m11", 2.0), (ALL, 0.5), (ALL, 2.0))


def fleet(name: str, number: str, factor: float, more: tuple[str, ...] = ()) -> Scenario:
    """Four boats of a hull with one number (or `ALL`) multiplied by `factor`."""
    vessel = presets.load(name).vessel
    keys = [key for group in (GROUPS if number == ALL else (number,)) for key in GROUPS[group]]
    changes = [
        f"boat.{boat}.vessel.{key}={factor * getattr(vessel, key)!r}"
        for boat in range(1, BOATS + 1)
        for key in keys
    ]
    return scenario.load("mixed", [*alike(name), *more, *changes])


def measured(
    names: list[str], cases: tuple[tuple[str, float], ...] = CASES, more: tuple[str, ...] = ()
) -> dict[tuple[str, str, float], Found]:
    """How the fleets of these hulls sail, by hull, number and factor."""
    keys = [(name, number, factor) for name in names for number, factor in cases]
    runs = sail([fleet(*key, more) for key in keys], {})
    return {key: found_of(run) for key, run in zip(keys, runs, strict=True)}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("hulls", nargs="*", metavar="HULL", default=presets.names())
    parser.add_argument("--weather", action="store_true", help="in wind, current and noise")
    options = parser.parse_args()
    found = measured(options.hulls, CASES, WEATHER if options.weather else ())
    print("RMS, m, of the worst boat in the last third; a state where one left FORMATION\n")
    print(f"| hull | {' | '.join(f'{number} × {factor:g}' for number, factor in CASES)} |")
    print("|---|" + "--:|" * len(CASES))
    for name in options.hulls:
        cells = [found[name, number, factor].text for number, factor in CASES]
        print(f"| `{name}` | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
