# SPDX-License-Identifier: MIT
"""What came of one row of the matrix of faults."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Outcome:
    """One fault, as the boat that had to notice it took it.

    `detected_s`: from the fault's beginning until the boat left FORMATION, None where it went on;
    `state`: the one it went to, or all in turn; `thrust_after_N`: the greatest that its propellers
    were told after that, within the row's limit of time; `recovered_s`: from the fault's end until
    it was in FORMATION for good; `why`: what is not as the limits have it, empty where it passed.
    """

    fault: str
    detected_s: float | None
    state: str
    thrust_after_N: float
    recovered_s: float | None
    passed: bool
    why: str
