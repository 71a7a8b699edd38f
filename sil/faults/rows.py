# SPDX-License-Identifier: MIT
"""The rows of `matrix.toml`: faults, and the limits of their effects."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, ValidationError

from sil.scenario import scenario
from sil.scenario.scenario import Scenario
from sil.scenario.sections import Fault, NotNegative, Pair, Positive, Section
from sil.scenario.toml_errors import Source

FOLDER = Path(__file__).parent

State = Literal[
    "DISARMED",
    "HOLD",
    "MANUAL",
    "FORMATION",
    "COAST",
    "TEST",
    "FAULT",
    "AUTO",
    "GUIDED",
    "LOITER",
    "RTL",
]


class Row(Section):
    """A fault, or several at once, and the required response of `boat`.

    `states`: the states to which it may change within `detected_s` of the beginning; "FORMATION"
    allows it to go on. `then`: the state that must follow within `then_s`. There must be no thrust
    later than `off_s` after HOLD, FAULT or DISARMED began, except at the ESC `but`, which takes no
    commands. In COAST thrust must never rise. `error_m`: the greatest distance from the slot while
    the boat is in FORMATION without help. Within `recovered_s` of the fault's end (of its
    beginning, if it has no end) it must be back in FORMATION: by itself, or by an `operator` who
    disarms, arms and sets FORMATION, but never before. `insists`: this operator asks from the
    fault's beginning on, in vain until its end. `lasts_s`: the least time in the first state.
    `hold_s`: the operator sets HOLD that long after the fault's beginning. `home_s`: that long
    after the beginning the operator arms the boat, even from FAULT, and drives it by sticks that
    are centred 2 s later; only then may it give thrust. `told`: words of a STATUSTEXT that it must
    send after the beginning. `fence_m`: its FS_FENCE_M; the fault is then that the boat leaves its
    fence. `keeps_m` [ahead, least]: the boat must stay at least `least` away from the place that
    was `ahead` metres ahead of it when the last fault began.
    """

    name: Annotated[str, Field(pattern="^[a-z0-9_]+$")]
    fault: Annotated[tuple[Fault, ...], Strict(False)] = ()
    boat: Annotated[int, Field(ge=1)] = 1
    states: Annotated[tuple[State, ...], Strict(False), Field(min_length=1)]
    detected_s: NotNegative | None = None
    then: State | None = None
    then_s: NotNegative = 0.0
    off_s: NotNegative = 0.011
    but: Literal["port", "stbd"] | None = None
    error_m: Positive | None = None
    recovery: Literal["automatic", "operator"] | None = None
    recovered_s: Positive | None = None
    insists: bool = False
    lasts_s: Positive | None = None
    hold_s: Positive | None = None
    home_s: Positive | None = None
    told: str | None = None
    fence_m: Positive | None = None
    keeps_m: Pair | None = None
    set: dict[str, Any] = Field(default_factory=dict)

    @property
    def begins_s(self) -> float:
        """Time of the first fault after the release; 0 if the fault is leaving the fence."""
        return min((fault.at_s for fault in self.fault), default=0.0)

    @property
    def asks_s(self) -> float:
        """Time from which on the operator asks for FORMATION."""
        return self.begins_s if self.insists else self.ends_s

    @property
    def ends_s(self) -> float:
        """Time when the faults end; if they never do, their beginning."""
        ends = [fault.at_s + fault.for_s for fault in self.fault if fault.for_s is not None]
        return max(ends, default=self.begins_s)

    def scenario(self) -> Scenario:
        """The scenario to sail; ScenarioError names the row."""
        source = scenario.read(FOLDER / "pair.toml")
        for key, value in self.set.items():
            source.override(f"{key}={json.dumps(value)}")
        if self.fence_m is not None:
            source.override(f"boat.{self.boat}.parameters.FS_FENCE_M={self.fence_m}")
        source.document["name"] = self.name
        source.document["fault"] = [fault.model_dump(exclude_unset=True) for fault in self.fault]
        return scenario.check(source)


class _Matrix(Section):
    row: Annotated[tuple[Row, ...], Strict(False), Field(min_length=1)]


def read(path: Path = FOLDER / "matrix.toml") -> tuple[Row, ...]:
    """Read the rows of a file; ScenarioError if it is invalid."""
    source = Source.read(path)
    try:
        return _Matrix.model_validate(source.document).row
    except ValidationError as error:
        raise source.errors(error, _Matrix) from None
