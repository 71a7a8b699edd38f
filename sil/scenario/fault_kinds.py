# SPDX-License-Identifier: MIT
"""The table of faults from `sil/native/fleet/fault.hpp`."""

from dataclasses import dataclass

import flotilla


@dataclass(frozen=True)
class Kind:
    """A fault: the part that fails, whether a virtual leader can have it, and its value.

    `unit` is empty if the fault takes no value. `drawn`: the range from which a soak draws the
    value, with either sign if `least` is negative; None if a soak never draws this fault.
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
