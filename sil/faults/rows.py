# SPDX-License-Identifier: MIT
"""The rows of `matrix.toml`: what goes wrong, and the limits of what may come of it."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, ValidationError

from sil.scenario import scenario
from sil.scenario.scenario import Scenario
from sil.scenario.sections import Fault, NotNegative, Positive, Section
from sil.scenario.toml_errors import Source

FOLDER = Path(__file__).parent

State = Literal["DISARMED", "HOLD", "MANUAL", "FORMATION", "COAST", "TEST", "FAULT"]


class Row(Section):
    """A fault, or several at once, and how `boat` has to take it.

    `states`: what it may change to, "FORMATION" where it may go on; within `detected_s` of the
    beginning. `then`: what that state has to end in, within `then_s` of its own beginning. No
    thrust later than `off_s` after HOLD, FAULT or DISARMED began, whatever `but` is told: an ESC
    that takes no commands. In COAST thrust never rises. `error_m`: the greatest distance from the
    slot while it is in FORMATION without anybody's help. Afterwards it is back in FORMATION within
    `recovered_s` of the fault's end (of its beginning, where it has none): by itself, or by an
    `operator` who disarms, arms and says FOLLOW, and never before he does. `hold_s`: the operator
    says HOLD so long after the fault's beginning. `home_s`: so long after it he arms the boat, out
    of FAULT too, and drives it by sticks that he centres 2 s later only: it pushes from then on,
    not before. `told`: it sends a STATUSTEXT with these words
    after the beginning. `fence_m`: its FS_FENCE_M; then the fault is to
    have left it.
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
    hold_s: Positive | None = None
    home_s: Positive | None = None
    told: str | None = None
    fence_m: Positive | None = None
    set: dict[str, Any] = Field(default_factory=dict)

    @property
    def begins_s(self) -> float:
        """When it goes wrong, after the release; 0 where it is to leave its fence."""
        return min((fault.at_s for fault in self.fault), default=0.0)

    @property
    def ends_s(self) -> float:
        """When all is well again; where that is never, when it went wrong."""
        ends = [fault.at_s + fault.for_s for fault in self.fault if fault.for_s is not None]
        return max(ends, default=self.begins_s)

    def scenario(self) -> Scenario:
        """What is sailed; ScenarioError names the row."""
        source = scenario.read(FOLDER / "pair.toml")
        for key, value in self.set.items():
            source.override(f"{key}={_toml(value)}")
        if self.fence_m is not None:
            source.override(f"boat.{self.boat}.parameters.FS_FENCE_M={self.fence_m}")
        source.document["name"] = self.name
        source.document["fault"] = [fault.model_dump(exclude_unset=True) for fault in self.fault]
        return scenario.check(source)


class _Matrix(Section):
    row: Annotated[tuple[Row, ...], Strict(False), Field(min_length=1)]


def read(path: Path = FOLDER / "matrix.toml") -> tuple[Row, ...]:
    """The rows of a file; ScenarioError says what is wrong with it."""
    source = Source.read(path)
    try:
        return _Matrix.model_validate(source.document).row
    except ValidationError as error:
        raise source.errors(error, _Matrix) from None


def _toml(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)
