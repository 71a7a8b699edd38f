# SPDX-License-Identifier: MIT
"""Checks of a scenario's `[[fault]]` entries."""

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

from sil.plant.sensors import SensorNoise
from sil.scenario.fault_kinds import KINDS
from sil.scenario.sections import Fault
from sil.scenario.toml_errors import KeyPath


def is_escs(fault: Fault) -> bool:
    """Whether the fault concerns an ESC."""
    return KINDS[fault.kind].owner == "ESCs"


def fault_contradictions(
    faults: Sequence[Fault], boats: int, noise: SensorNoise
) -> Iterator[tuple[KeyPath, str]]:
    """Key and problem of each mistake, given the scenario's boats and navigation noise."""
    for index, fault in enumerate(faults, start=1):
        for name, problem in _problems(fault, boats, noise):
            key = ("fault", str(index), name)
            given = getattr(fault, name)
            shown = f'"{given}"' if isinstance(given, str) else given
            yield key, f'"{".".join(key)}" = {shown}: {problem}'
    for (one, first), (other, second) in combinations(enumerate(faults, start=1), 2):
        if _meet(first, second):
            key = ("fault", str(other), "at_s")
            same = f"overlaps fault {one}, of the same kind and agent"
            yield key, f'"{".".join(key)}" = {second.at_s}: {same}'


def _meet(one: Fault, other: Fault) -> bool:
    """Whether ending one fault would also end the other."""
    if (one.kind, one.agent) != (other.kind, other.agent):
        return False
    both = one.esc == other.esc or "both" in (one.esc, other.esc)
    return both and _begin_s(one) < _end_s(other) and _begin_s(other) < _end_s(one)


def _begin_s(fault: Fault) -> float:
    return fault.at_s - (fault.value if fault.kind == "replay" else 0.0)


def _end_s(fault: Fault) -> float:
    return math.inf if fault.for_s is None else fault.at_s + fault.for_s


def _problems(fault: Fault, boats: int, noise: SensorNoise) -> Iterator[tuple[str, str]]:
    kind, known = fault.kind, KINDS[fault.kind]
    if fault.agent > boats:
        yield "agent", f"there are agents 0 to {boats}"
    if fault.agent == 0 and not known.leaders:
        yield "agent", f"the virtual leader cannot have {kind}"
    if fault.esc != "both" and not is_escs(fault):
        yield "esc", f"{kind} is not a fault of ESCs"
    if not known.unit:
        if fault.value:
            yield "value", f"{kind} takes no value"
    elif "value" not in fault.model_fields_set:
        yield "value", f"{kind} needs a value ({known.unit})"
    elif not known.least <= fault.value <= known.greatest:
        limits = f"from {known.least:g} to {known.greatest:g}"
        yield "value", f"{kind} takes a value {limits} ({known.unit})"
    if kind == "replay" and not 0.0 < fault.value <= fault.at_s:
        yield (
            "value",
            "must be positive and at most at_s: replay repeats what was sent that long ago",
        )
    if kind == "own_noisy" and not noise.sigma.any():
        yield "kind", "[navigation] has no noise to multiply"
