# SPDX-License-Identifier: MIT
"""Scenarios: TOML files that say who sails where, in what hull, over what radio.

`sil/scenarios/diamond.toml` shows every key with its unit; `sil/README.md` lists the scenarios. A
file with `base = "NAME"` is that scenario with its own keys over it, boats by number: `[boat.2]`.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, Strict, StringConstraints, ValidationError

from sil import toml_errors
from sil.plant.hull import Array, HullParameters
from sil.plant.propeller import PropellerParameters
from sil.plant.sensors import SensorNoise
from sil.toml_errors import KeyPath, ScenarioError
from sil.wire.navigation_unit import Message, Settings

__all__ = ["Scenario", "ScenarioError", "load"]

FOLDER = Path(__file__).parent / "scenarios"

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
# TOML has arrays only: Strict(False) lets them be tuples, their numbers stay strict
Pair = Annotated[tuple[float, float], Strict(False)]
Triple = Annotated[tuple[float, float, float], Strict(False)]
ParameterName = Annotated[str, StringConstraints(pattern=r"^[A-Z][A-Z0-9_]{0,15}$")]


class Section(BaseModel):
    """A table of the file: unknown keys, wrong types and NaN are errors; immutable."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Vessel(Section):
    """Inertia with added mass (kg, kg, kg m²) and linear drag (N s/m, N s/m, N m s)."""

    m11: Positive = 1.012
    m22: Positive = 1.982
    m33: Positive = 0.354
    d11: NotNegative = 3.436
    d22: NotNegative = 18.99
    d33: NotNegative = 0.864


class Propellers(Section):
    """The two propellers of a boat, as `sil.plant.propeller` has them.

    The defaults are what the firmware's THR_* expect by default.
    """

    arm_m: Positive = 0.25
    forward_max_N: Positive = 20.0
    reverse_max_N: NotNegative = 20.0
    expo: Share = 0.0
    lag_s: NotNegative = 0.0


class Unit(Section):
    """What a navigation unit says: `sil.wire.navigation_unit.Settings` explains the keys."""

    rate_hz: Positive = 100.0
    message: Message = "local"
    attitude_rate_hz: NotNegative = 0.0
    origin_m: Pair = (0.0, 0.0)


class Navigation(Unit):
    """The boats' navigation units: what they say, standard deviations of their noise."""

    position_noise_m: NotNegative = 0.0
    heading_noise_rad: NotNegative = 0.0
    velocity_noise_mps: NotNegative = 0.0
    yaw_rate_noise_radps: NotNegative = 0.0

    @property
    def noise(self) -> SensorNoise:
        """The noise as `sil.plant.sensors` takes it."""
        return SensorNoise(
            self.position_noise_m,
            self.heading_noise_rad,
            self.velocity_noise_mps,
            self.yaw_rate_noise_radps,
        )


class Link(Section):
    """Radio between boats; `rate_Bps` 0 is unlimited."""

    delay_s: NotNegative = 0.0
    jitter_s: NotNegative = 0.0
    loss: Share = 0.0
    rate_Bps: NotNegative = 0.0


class Clocks(Section):
    """Largest offset and drift of each vessel's own clock, drawn by the seed."""

    offset_s: NotNegative = 0.0
    drift_ppm: NotNegative = 0.0


class Input(Section):
    """Agent 0's input from `from_s` on: [surge_N, yaw_Nm + yaw_sine_Nm sin(yaw_sine_rad_s t)]."""

    from_s: NotNegative = 0.0
    surge_N: float = 0.0
    yaw_Nm: float = 0.0
    yaw_sine_Nm: float = 0.0
    yaw_sine_rad_s: float = 0.0


class Leader(Section):
    """The virtual leader, agent 0: pose (m, m, rad), velocity (m/s, m/s, rad/s), input.

    Its unit says what it says itself, at the boats' rate unless it has its own.
    """

    eta: Triple = (0.0, 0.0, 0.0)
    nu: Triple = (0.0, 0.0, 0.0)
    navigation: Unit = Unit()
    input: Annotated[tuple[Input, ...], Strict(False)] = ()

    def tau(self, t_s: Array) -> Array:
        """Input [X N] (..., 2) in N, N m at times `t_s` (...) after release; 0 before the first."""
        tau = np.zeros((*t_s.shape, 2))
        for segment in self.input:
            now = t_s >= segment.from_s
            sine = segment.yaw_sine_Nm * np.sin(segment.yaw_sine_rad_s * t_s[now])
            tau[now, 0] = segment.surge_N
            tau[now, 1] = segment.yaw_Nm + sine
        return tau


class Boat(Section):
    """A boat: the agent it follows, its slot north and east of it, start; own deviations."""

    follows: Annotated[int, Field(ge=0)]
    offset_m: Pair
    eta: Triple
    nu: Triple = (0.0, 0.0, 0.0)
    parameters: dict[ParameterName, float] = {}
    vessel: Vessel = Vessel()
    propellers: Propellers = Propellers()
    navigation: Unit = Unit()


class Scenario(Section):
    """A whole scenario. Agent 0 is the virtual leader, agent i is `boat[i - 1]`.

    `name` is the file's unless the file gives another.
    """

    name: str
    duration_s: Positive
    seed: Annotated[int, Field(ge=0)] = 1
    scalar: Literal["float", "double"] = "float"
    rate_hz: Annotated[float, Field(ge=50.0, le=1000.0)] = 100.0
    vessel: Vessel = Vessel()
    propellers: Propellers = Propellers()
    navigation: Navigation = Navigation()
    link: Link = Link()
    clocks: Clocks = Clocks()
    leader: Leader
    parameters: dict[ParameterName, float] = {}
    boat: Annotated[tuple[Boat, ...], Strict(False), Field(min_length=1)]

    def hulls(self) -> list[HullParameters]:
        """Hull of every agent, the virtual leader first."""
        deviations = [Vessel(), *(boat.vessel for boat in self.boat)]
        return [HullParameters(**_merged(self.vessel, deviation)) for deviation in deviations]

    def propeller_pairs(self) -> list[PropellerParameters]:
        """Propellers of every boat, boat 1 first."""
        deviations = [boat.propellers for boat in self.boat]
        return [PropellerParameters(**_merged(self.propellers, own)) for own in deviations]

    def leader_unit(self) -> Settings:
        """What the virtual leader says."""
        own = self.leader.navigation.model_dump(exclude_unset=True)
        return Settings(**{"rate_hz": self.navigation.rate_hz, **own})

    def boat_unit(self, boat: Boat) -> Settings:
        """What the navigation unit of `boat` says."""
        common = self.navigation.model_dump(include=set(Unit.model_fields))
        return Settings(**{**common, **boat.navigation.model_dump(exclude_unset=True)})

    def firmware_parameters(self, boat: Boat) -> dict[str, float]:
        """Firmware parameters that the file gives `boat`: those of all, then its own."""
        return {**self.parameters, **boat.parameters}


def load(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """Read a scenario: a name in `sil/scenarios`, or the path of a TOML file.

    `overrides` are `KEY=VALUE`: dotted keys, boats counted from 1, values as TOML has them
    (`link.delay_s=0.1`, `boat.2.eta=[0, 0, 0]`).

    Raises ScenarioError, whose text names file, line and key (or the override) and what is allowed.
    """
    path = _find(name_or_path)
    source = _read(path)
    for override in overrides:
        source.override(override)
    try:
        scenario = Scenario.model_validate({"name": path.stem, **source.document})
    except ValidationError as error:
        raise source.errors(error, Scenario) from None
    for key, problem in _contradictions(scenario):
        raise source.error(key, problem)
    return scenario


def _read(path: Path) -> toml_errors.Source:
    source = toml_errors.Source.read(path)
    if "base" in source.document:
        name = source.document.pop("base")
        try:
            base = toml_errors.Source.read(_find(name))
        except (ScenarioError, TypeError) as error:
            raise source.error(("base",), f'"base": {error}') from None
        if "base" in base.document:
            raise source.error(("base",), f'"base" = "{name}": that scenario has a base itself')
        source.lay_over(base)
    return source


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix == ".toml":
        return path
    known = sorted(file.stem for file in FOLDER.glob("*.toml"))
    if str(name_or_path) not in known:
        raise ScenarioError(f'unknown scenario "{name_or_path}"; there are: {", ".join(known)}')
    return FOLDER / f"{name_or_path}.toml"


def _merged(common: Section, own: Section) -> dict[str, Any]:
    return {**common.model_dump(), **own.model_dump(exclude_unset=True)}


def _contradictions(scenario: Scenario) -> Iterator[tuple[KeyPath, str]]:
    key: KeyPath
    for index, boat in enumerate(scenario.boat, start=1):
        if boat.follows >= index:
            key = ("boat", str(index), "follows")
            allowed = f"boat {index} may follow agents 0 to {index - 1}"
            yield key, f'"{".".join(key)}" = {boat.follows}: {allowed}'
    yield from _unit_contradictions(scenario)
    starts = [segment.from_s for segment in scenario.leader.input]
    for index in range(1, len(starts)):
        if starts[index] <= starts[index - 1]:
            key = ("leader", "input", str(index + 1), "from_s")
            later = f"must be later than {starts[index - 1]}"
            yield key, f'"{".".join(key)}" = {starts[index]}: {later}'


def _unit_contradictions(scenario: Scenario) -> Iterator[tuple[KeyPath, str]]:
    units: list[tuple[KeyPath, Settings]] = [(("leader", "navigation"), scenario.leader_unit())]
    for index, boat in enumerate(scenario.boat, start=1):
        units.append((("boat", str(index), "navigation"), scenario.boat_unit(boat)))
    common = scenario.navigation.model_dump(include=set(Unit.model_fields))
    units.insert(0, (("navigation",), Settings(**common)))
    for place, unit in units:
        path = ".".join(place)
        for name in ("rate_hz", "attitude_rate_hz"):
            if getattr(unit, name) > scenario.rate_hz:
                ticks = f"the world ticks at rate_hz = {scenario.rate_hz}"
                yield (*place, name), f'"{path}.{name}" = {getattr(unit, name)}: {ticks}'
        if unit.attitude_rate_hz and unit.message not in ("local", "global"):
            key = f'"{path}.attitude_rate_hz" = {unit.attitude_rate_hz}'
            yield (*place, "attitude_rate_hz"), f'{key}: "{unit.message}" sends no ATTITUDE'
        if any(unit.origin_m) and unit.message != "local":
            key = f'"{path}.origin_m" = {list(unit.origin_m)}'
            yield (*place, "origin_m"), f'{key}: only "local" has an origin of its own'
