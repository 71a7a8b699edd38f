# SPDX-License-Identifier: MIT
"""The outcome of one row of the matrix of faults."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Outcome:
    """The response to a fault of the boat that had to detect it.

    `detected_s`: from the fault's beginning until the boat left FORMATION; None if it did not.
    `state`: the state it changed to, or all states in order. `thrust_after_N`: the greatest
    commanded thrust once the row's time limit for stopping had passed. `recovered_s`: from the
    fault's end until the boat was in FORMATION for good. `why`: the limits that were missed, empty
    if none.
    """

    fault: str
    detected_s: float | None
    state: str
    thrust_after_N: float
    recovered_s: float | None
    passed: bool
    why: str
