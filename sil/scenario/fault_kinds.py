# SPDX-License-Identifier: MIT
"""The table of faults, as `sil/native/fleet/fault.hpp` has it."""

from dataclasses import dataclass

import flotilla


@dataclass(frozen=True)
class Kind:
    """A fault: the part that fails, whether virtual leaders can have it, and its value.

    `unit` is empty where it takes no value. `drawn`: the range that a soak draws the value from,
    with either sign where `least` is negative; None where a soak never has it.
    """

    name: str
    owner: str
    leaders: bool
    unit: str
    least: float
    greatest: float
    drawn: tuple[float, float] | None
    meaning: str


KINDS = {row["name"]: Kind(**row) for row in flotilla.fault_list()}
