# SPDX-License-Identifier: MIT
"""The tables of a scenario file; `sil/scenarios/diamond.toml` shows every key with its unit."""

from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, Strict, StringConstraints

from sil.plant.hull import Array, HullParameters
from sil.plant.sensors import SensorNoise
from sil.plant.waves import WATER_KGPM3
from sil.plant.wind import Windage
from sil.scenario.fault_kinds import KINDS
from sil.wire.navigation_unit import Message

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
# TOML has only arrays: Strict(False) turns them into tuples; their numbers stay strict
Pair = Annotated[tuple[float, float], Strict(False)]
Triple = Annotated[tuple[float, float, float], Strict(False)]
Scalar = Literal["float", "double", "q16"]
ParameterName = Annotated[str, StringConstraints(pattern=r"^[A-Z][A-Z0-9_]{0,15}$")]
Parameters = dict[ParameterName, float]


class Section(BaseModel):
    """A table of the file: unknown keys, wrong types and NaN are errors; immutable."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Vessel(Section):
    """A hull; the default is the paper's hull, which has only the first six parameters.

    Inertia with added mass (kg, kg, kg m²) and linear drag (N s/m, N s/m, N m s); then the terms
    that the law does not model, see `sil.plant.hull.HullParameters`, and the surfaces exposed to
    the weather, see `sil.plant.wind.Windage` and `sil.plant.waves.WaveBody`.
    """

    m11: Positive = 1.012
    m22: Positive = 1.982
    m33: Positive = 0.354
    d11: NotNegative = 3.436
    d22: NotNegative = 18.99
    d33: NotNegative = 0.864
    m23: float = 0.0
    d11_quadratic: NotNegative = 0.0
    d33_quadratic: NotNegative = 0.0
    d33_speed: NotNegative = 0.0
    crossflow_cd: NotNegative = 0.0
    length_m: NotNegative = 0.0
    draft_m: NotNegative = 0.0
    hull_y_m: NotNegative = 0.0
    frontal_m2: NotNegative = 0.0
    lateral_m2: NotNegative = 0.0
    wind_x: NotNegative = 0.0
    wind_y: NotNegative = 0.0
    wind_n: NotNegative = 0.0
    drift_x_m: NotNegative = 0.0
    drift_y_m: NotNegative = 0.0

    @property
    def hull(self) -> HullParameters:
        """The hull's parameters for `sil.plant.hull`."""
        density = 0.5 * WATER_KGPM3 * self.draft_m * self.crossflow_cd
        names = [field.name for field in fields(HullParameters) if field.name != "crossflow"]
        return HullParameters(**self.model_dump(include=set(names)), crossflow=density)

    @property
    def windage(self) -> Windage:
        """The hull's surfaces in the wind."""
        coefficients = (self.wind_x, self.wind_y, self.wind_n)
        return Windage(self.frontal_m2, self.lateral_m2, *coefficients, self.length_m)


class Wind(Section):
    """Velocity of the air, north and east; standard deviation and time constant of its gusts."""

    mean_mps: Pair = (0.0, 0.0)
    gust_mps: NotNegative = 0.0
    gust_s: Positive = 10.0


class Waves(Section):
    """Significant height (0: none), peak period, course, JONSWAP's peakedness, sinusoids."""

    height_m: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    period_s: Positive = 2.0
    course_rad: float = 0.0
    peakedness: Annotated[float, Field(ge=1.0, le=7.0)] = 3.3
    components: Annotated[int, Field(ge=1, le=1000)] = 40


class Water(Section):
    """Velocity of the water, north and east, uniform."""

    current_mps: Pair = (0.0, 0.0)


class WhiteNoise(Section):
    """A random force on each axis of the boats, see `sil.plant.weather.WhiteNoise`; 0: none."""

    power: NotNegative = 0.0
    sample_s: Positive = 0.01


class Mismatch(Section):
    """Greatest relative deviation of each of a boat's six hull parameters from the firmware's."""

    share: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0


class Propellers(Section):
    """The two propellers of a boat, see `sil.plant.propeller`.

    The defaults match the firmware's defaults of THR_*. `port_gain` and `stbd_gain` are the shares
    of that thrust that the two propellers give.
    """

    arm_m: Positive = 0.25
    forward_max_N: Positive = 20.0
    reverse_max_N: NotNegative = 20.0
    expo: Share = 0.0
    lag_s: NotNegative = 0.0
    port_gain: Positive = 1.0
    stbd_gain: Positive = 1.0
    dead: Share = 0.0


class Unit(Section):
    """A navigation unit's messages; `sil.wire.navigation_unit.Settings` explains the keys."""

    rate_hz: Positive = 100.0
    message: Message = "local"
    attitude_rate_hz: NotNegative = 0.0
    origin_m: Pair = (0.0, 0.0)
    delay_s: NotNegative = 0.0
    timesync: bool = True
    dropout_every_s: NotNegative = 0.0
    dropout_s: NotNegative = 0.0


class Navigation(Unit):
    """The boats' navigation units: messages, and standard deviations of their noise.

    `position_drift_m`: standard deviation of a slow position error with time constant
    `position_drift_s`.
    """

    position_noise_m: NotNegative = 0.0
    heading_noise_rad: NotNegative = 0.0
    velocity_noise_mps: NotNegative = 0.0
    yaw_rate_noise_radps: NotNegative = 0.0
    position_drift_m: NotNegative = 0.0
    position_drift_s: Positive = 60.0

    @property
    def noise(self) -> SensorNoise:
        """The noise for `sil.plant.sensors`."""
        return SensorNoise(
            self.position_noise_m,
            self.heading_noise_rad,
            self.velocity_noise_mps,
            self.yaw_rate_noise_radps,
            self.position_drift_m,
            self.position_drift_s,
        )


class Link(Section):
    """Radio between boats; `rate_Bps` 0 is unlimited.

    `everyone`: every boat hears all others, not only its leader and followers. Boats that do not
    hear each other keep no distance from each other (`FS_SEP_M`).
    """

    delay_s: NotNegative = 0.0
    jitter_s: NotNegative = 0.0
    loss: Share = 0.0
    rate_Bps: NotNegative = 0.0
    everyone: bool = False

    @property
    def quality(self) -> dict[str, float]:
        """A link's parameters for `flotilla.Fleet.connect` and `sil.wire.link.Link`."""
        return self.model_dump(exclude={"everyone"})


class Clocks(Section):
    """Largest offset and drift of each vessel's own clock; the seed determines the values."""

    offset_s: Annotated[float, Field(ge=0.0, le=1e9)] = 0.0
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

    Alternatively `waypoints`, places north and east (m). The leader begins at the first one with
    its bow to the second one, sails straight legs at `speed_mps`, and stops at the last one. It
    rounds the corners on arcs of at least `corner_radius_m` if the legs are long enough. It is then
    a reference without a hull: the current does not carry it. Its navigation unit sends the
    reference's state, at the boats' rate unless it has its own rate.

    With `boat = 1` there is no virtual leader: boat 1 gets the waypoints as its plan by MAVLink,
    sails it in AUTO and sends the reference to the others. Agent 0 is then the plan itself; boats
    that follow agent 0 receive it from boat 1. With `voyage_room_m` (0: the firmware's default),
    boat 1 measures its hull around the last waypoint, alone, with at most `voyage_share` of its
    thrust (0: the firmware's).
    """

    eta: Triple = (0.0, 0.0, 0.0)
    nu: Triple = (0.0, 0.0, 0.0)
    navigation: Unit = Unit()
    input: Annotated[tuple[Input, ...], Strict(False)] = ()
    waypoints: Annotated[tuple[Pair, ...], Strict(False)] = ()
    speed_mps: Positive = 0.5
    corner_radius_m: NotNegative | None = None
    boat: Literal[1] | None = None
    voyage_room_m: NotNegative | None = None
    voyage_share: Share = 0.0

    @property
    def name(self) -> str:
        """Name of agent 0 in pictures and tables."""
        return "virtual leader" if self.boat is None else f"plan of boat {self.boat}"

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
    """A boat: the agent that it follows, its slot north and east of that agent, its start.

    It may deviate from the scenario's vessel, propellers and other settings.
    """

    follows: Annotated[int, Field(ge=0)]
    offset_m: Pair
    eta: Triple
    nu: Triple = (0.0, 0.0, 0.0)
    hull: str | None = None
    parameters: Parameters = Field(default_factory=dict)
    vessel: Vessel = Vessel()
    propellers: Propellers = Propellers()
    navigation: Unit = Unit()


if TYPE_CHECKING:
    FaultKind = str
else:
    FaultKind = Literal[tuple(KINDS)]


class Fault(Section):
    """A fault of an agent from `at_s` after the release on, for `for_s` or to the end.

    sil/docs/FAULTS.md explains the kinds and gives the unit of `value` for each. `esc`: the ESC
    that fails, for a fault of ESCs.
    """

    kind: FaultKind
    agent: Annotated[int, Field(ge=0)]
    at_s: NotNegative
    for_s: Positive | None = None
    value: float = 0.0
    esc: Literal["port", "stbd", "both"] = "both"

    def sentence(self, leader: str) -> str:
        """Describe the fault, its agent and its time in one line; `leader`: the name of agent 0."""
        value = f" {self.value:g}" if self.value else ""
        whom = f"boat {self.agent}" if self.agent else leader
        ends = "to the end" if self.for_s is None else f"for {self.for_s:g} s"
        return f"fault: {self.kind}{value}, {whom}, from {self.at_s:g} s {ends}"


class Vary(Section):
    """A key of the scenario that a campaign draws anew for each run; a single run ignores it.

    `key`: dotted; `*` instead of a boat's number means every boat, each with its own draw; array
    elements count from 1 (`boat.*.eta.3`), a whole array is drawn element by element. Exactly one
    of `normal` [mean, standard deviation], `uniform` [low, high] and `choice` [values …] gives the
    distribution. `combine`: whether the draw replaces the file's number, is added to it, or scales
    it.
    """

    key: Annotated[str, StringConstraints(pattern=r"^[^.\s]+(\.[^.\s]+)*$")]
    normal: Pair | None = None
    uniform: Pair | None = None
    choice: Annotated[tuple[int | float | str, ...], Strict(False), Field(min_length=1)] | None = (
        None
    )
    combine: Literal["set", "add", "scale"] = "set"
