# SPDX-License-Identifier: MIT
"""Scenarios: TOML files that describe boats, hulls, formation, radio and weather.

`sil/scenarios/diamond.toml` shows every key with its unit; `sil/docs/SCENARIOS.md` lists them. A
file with `base = "NAME"` overrides keys of that scenario, boats by number: `[boat.2]`.
"""

import difflib
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, pairwise, takewhile
from pathlib import Path
from typing import Annotated, Any

import flotilla
from pydantic import Field, Strict, ValidationError

from sil import ROOT
from sil.plant.hull import Array, HullParameters
from sil.plant.propeller import PropellerParameters
from sil.plant.weather import steps_of
from sil.scenario import formation, hulls, law, toml_errors
from sil.scenario.fault_errors import fault_contradictions
from sil.scenario.formation import Formation
from sil.scenario.law import Law
from sil.scenario.route import fastest, half_width_m, plans_width_m, route, sharpest, turning
from sil.scenario.sections import (
    Boat,
    Clocks,
    Fault,
    Leader,
    Link,
    Mismatch,
    Navigation,
    NotNegative,
    Parameters,
    Propellers,
    Scalar,
    Section,
    Unit,
    Vary,
    Vessel,
    Water,
    Waves,
    WhiteNoise,
    Wind,
)
from sil.scenario.toml_errors import KeyPath, ScenarioError
from sil.wire.navigation_unit import Settings

__all__ = ["Boat", "Leader", "Propellers", "Scenario", "ScenarioError", "Vessel", "load"]

_SHORTEST_LEG_M = 0.1
_INNERMOST = 0.8  # greatest distance of a slot abeam of the leader, as a share of a corner's radius

FOLDER = ROOT / "sil" / "scenarios"


class Scenario(Section):
    """A whole scenario. Agent 0 is the virtual leader, agent i is `boat[i - 1]`.

    `name` is the file's name by default. `hull`, a name in `sil/hulls`, selects that hull's
    `vessel`, `propellers` and `parameters`; the file's keys override them. A campaign draws no
    start at which two boats are closer than `start_apart_m`.
    """

    name: str
    duration_s: Annotated[float, Field(gt=0.0, le=1e6)]
    seed: Annotated[int, Field(ge=0)] = 1
    law: Law = "product"
    scalar: Scalar = "float"
    rate_hz: Annotated[float, Field(ge=50.0, le=1000.0)] = 100.0
    start_apart_m: NotNegative = 0.0
    hull: str | None = None
    vessel: Vessel = Vessel()
    propellers: Propellers = Propellers()
    navigation: Navigation = Navigation()
    water: Water = Water()
    wind: Wind = Wind()
    waves: Waves = Waves()
    white_noise: WhiteNoise = WhiteNoise()
    mismatch: Mismatch = Mismatch()
    link: Link = Link()
    clocks: Clocks = Clocks()
    leader: Leader
    formation: Formation | None = None
    parameters: Parameters = Field(default_factory=dict)
    boat: Annotated[tuple[Boat, ...], Strict(False), Field(min_length=1)]
    fault: Annotated[tuple[Fault, ...], Strict(False)] = ()
    vary: Annotated[tuple[Vary, ...], Strict(False)] = ()

    @property
    def step_s(self) -> float:
        """Period of the control ticks and of the plant's steps, s."""
        return 1e-6 * round(1e6 / self.rate_hz)

    @property
    def ticks(self) -> int:
        """Number of ticks from the release to the end, both included."""
        return round(self.duration_s / self.step_s) + 1

    def vessels(self) -> list[Vessel]:
        """Vessel of every agent, from the file, the virtual leader first."""
        deviations = [Vessel(), *(boat.vessel for boat in self.boat)]
        return [
            Vessel(**_merged(self.vessel, own)) if own.model_fields_set else self.vessel
            for own in deviations
        ]

    def hulls(self) -> list[HullParameters]:
        """Hull of every agent, the virtual leader first, without mismatch."""
        return [vessel.hull for vessel in self.vessels()]

    def propeller_pairs(self) -> list[PropellerParameters]:
        """Propellers of every boat, boat 1 first."""
        deviations = [boat.propellers for boat in self.boat]
        return [PropellerParameters(**_merged(self.propellers, own)) for own in deviations]

    def leader_unit(self) -> Settings:
        """Settings of the virtual leader's navigation unit."""
        own = self.leader.navigation.model_dump(exclude_unset=True)
        return Settings(**{"rate_hz": self.navigation.rate_hz, **own})

    def boat_unit(self, boat: Boat) -> Settings:
        """Settings of the navigation unit of `boat`."""
        common = self.navigation.model_dump(include=set(Unit.model_fields))
        return Settings(**{**common, **boat.navigation.model_dump(exclude_unset=True)})

    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of agents with a radio link: leader and follower; with `everyone`, all boats."""
        pairs = [(self.heard_by(agent), agent) for agent in range(1, len(self.boat) + 1)]
        pairs = [pair for pair in pairs if pair[0] != pair[1]]
        if self.link.everyone:
            boats = range(1, len(self.boat) + 1)
            pairs += [pair for pair in combinations(boats, 2) if pair not in pairs]
        return pairs

    def heard_by(self, agent: int) -> int:
        """The agent that a boat hears as its leader: the one it follows, or the boat with the plan.

        A boat that leads hears no other: the result is the boat itself.
        """
        follows = self.boat[agent - 1].follows
        return follows or self.leader.boat or 0

    def firmware_parameters(self, boat: Boat) -> dict[str, float]:
        """Firmware parameters of `boat` from the file: the law's, then all boats', then its own."""
        own = {**law.parameters(self.law), **self.parameters, **boat.parameters}
        if self.leader.boat is not None and boat is self.boat[self.leader.boat - 1]:
            own.setdefault("WP_WIDTH", plans_width_m(self.leader, self.boat))
        return own

    def route(self, parameters: Mapping[str, float] | None = None) -> Array:
        """The leader's motion (ticks + 1, 10) along its waypoints, as `sil.scenario.route.route`.

        `parameters`: firmware parameters of a boat that leads; by default the file's.
        """
        if parameters is None and self.leader.boat is not None:
            parameters = self.firmware_parameters(self.boat[self.leader.boat - 1])
        return route(self.leader, self.boat, self.step_s, self.ticks, parameters)


def load(
    name_or_path: str | Path, overrides: Sequence[str] = (), law_override: Law | None = None
) -> Scenario:
    """Read a scenario: a name in `sil/scenarios`, or the path of a TOML file.

    `law_override` replaces the file's law and gains, see `sil.scenario.law.impose`; `overrides`
    are applied after that. They are `KEY=VALUE`: dotted keys, boats counted from 1, TOML values
    (`link.delay_s=0.1`, `boat.2.eta=[0, 0, 0]`) or bare words (`scalar=q16`).

    Raises ScenarioError; its text names file, line and key (or the override) and what is allowed.
    """
    return check(read(name_or_path, overrides, law_override))


def read(
    name_or_path: str | Path, overrides: Sequence[str] = (), law_override: Law | None = None
) -> toml_errors.Source:
    """The complete document of a scenario for `load`, not yet checked."""
    path = path_of(name_or_path)
    source = _read(path)
    source.document.setdefault("name", path.stem)
    # The route and the shape come first: they make the boats, which other overrides may change.
    makers = [text for text in overrides if text.lstrip().startswith(("leader.", "formation."))]
    for override in makers:
        source.override(override)
    formation.expand(source)
    named = [text for text in overrides if hulls.is_hull(text.partition("=")[0])]
    for override in named:
        hulls.override(source, override)
    if law_override is not None:
        law.impose(law_override, source.document)
    # The law decides which of a hull's gains count.
    laws = [text for text in overrides if text.partition("=")[0].strip() == "law"]
    for override in laws:
        source.override(override)
    hulls.expand(source)
    for override in overrides:
        if override not in (*makers, *named, *laws):
            source.override(override)
    return source


def check(source: toml_errors.Source) -> Scenario:
    """Check a document and make its scenario; ScenarioError as for `load`."""
    try:
        scenario = Scenario.model_validate(source.document)
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
            base = toml_errors.Source.read(path_of(name))
        except (ScenarioError, TypeError) as error:
            raise source.error(("base",), f'"base": {error}') from None
        if "base" in base.document:
            raise source.error(
                ("base",), f'"base" = "{name}": that scenario has a base itself, name one without'
            )
        hulls.clear_base(source.document, base.document)
        source.lay_over(base)
    return source


def about(path: Path) -> str:
    """The first sentence of the comment at the top of a scenario's file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    comment = takewhile(lambda line: line.startswith("#"), lines)
    words = " ".join(line.lstrip("# ") for line in comment if "SPDX" not in line)
    return re.split(r"(?<!Fig)\. |; |: ", words)[0].rstrip(".")


def path_of(name_or_path: str | Path) -> Path:
    """The file of a scenario, by its name or path; ScenarioError if there is no such name."""
    path = Path(name_or_path)
    if path.suffix == ".toml":
        return path
    known = sorted(file.stem for file in FOLDER.glob("*.toml"))
    if str(name_or_path) not in known:
        near = difflib.get_close_matches(str(name_or_path), known, 1)
        hint = f'did you mean "{near[0]}"? There' if near else "there"
        raise ScenarioError(f'unknown scenario "{name_or_path}"; {hint} are {", ".join(known)}')
    return FOLDER / f"{name_or_path}.toml"


def _merged(common: Section, own: Section) -> dict[str, Any]:
    return {**common.model_dump(), **own.model_dump(exclude_unset=True)}


def _contradictions(scenario: Scenario) -> Iterator[tuple[KeyPath, str]]:
    key: KeyPath
    name = scenario.name
    if name in ("", ".", "..") or not name.isprintable() or set(name) & set("/\\"):
        told = json.dumps(name, ensure_ascii=False)
        yield ("name",), f'"name" = {told}: must be one folder\'s name, for the results in out/'
    for index, boat in enumerate(scenario.boat, start=1):
        if boat.follows >= index:
            key = ("boat", str(index), "follows")
            allowed = f"boat {index} may follow agents 0 to {index - 1}"
            yield key, f'"{".".join(key)}" = {boat.follows}: {allowed}'
    yield from _unit_contradictions(scenario)
    yield from fault_contradictions(scenario.fault, len(scenario.boat), scenario.navigation.noise)
    noise = scenario.white_noise
    if noise.power:
        try:
            steps_of(noise.sample_s, 1e-6 * round(1e6 / scenario.rate_hz))
        except ValueError as error:
            key = ("white_noise", "sample_s")
            yield key, f'"{".".join(key)}" = {noise.sample_s}: {error}'
    for index, vessel in enumerate(scenario.vessels()):
        if vessel.m23 * vessel.m23 >= vessel.m22 * vessel.m33:
            key = ("boat", str(index), "vessel", "m23") if index else ("vessel", "m23")
            yield key, f'"{".".join(key)}" = {vessel.m23}: its square must be less than m22 × m33'
    yield from _plan_contradictions(scenario)
    yield from _route_contradictions(scenario)
    starts = [segment.from_s for segment in scenario.leader.input]
    for index in range(1, len(starts)):
        if starts[index] <= starts[index - 1]:
            key = ("leader", "input", str(index + 1), "from_s")
            later = f"must be later than {starts[index - 1]}"
            yield key, f'"{".".join(key)}" = {starts[index]}: {later}'


def _route_contradictions(scenario: Scenario) -> Iterator[tuple[KeyPath, str]]:
    points = scenario.leader.waypoints
    if not points:
        return
    if len(points) == 1:
        yield ("leader", "waypoints"), '"leader.waypoints": must have at least two points'
        return
    for number, (a, b) in enumerate(pairwise(points), start=2):
        if math.dist(a, b) < _SHORTEST_LEG_M:
            near = f"waypoint {number} is less than {_SHORTEST_LEG_M} m from the one before"
            yield ("leader", "waypoints"), f'"leader.waypoints": {near}'
            return
    # Nearer to the centre of the turn, a slot would nearly stand still, or go astern.
    width_m = half_width_m(scenario.boat)
    motion = scenario.route()
    curvature, number = sharpest(motion)
    if width_m * curvature > _INNERMOST * (1.0 + 1e-9):
        wanted = width_m / _INNERMOST
        yield (
            ("leader", "waypoints"),
            f'"leader.waypoints": the corner at waypoint {number} has a radius of '
            f"{1 / curvature:.1f} m, slots {width_m:.1f} m abeam that turn with the leader need "
            f"{wanted:.1f} m: make legs longer, corner_radius_m greater, or slots nearer",
        )
        return
    if scenario.law == "product":
        yield from _swung_out(scenario, motion)


def _swung_out(scenario: Scenario, motion: Array) -> Iterator[tuple[KeyPath, str]]:
    """Report slots that turn with the leader and are too fast in a corner."""
    for agent, place in turning(scenario.boat).items():
        if agent == 0:
            continue
        own = scenario.firmware_parameters(scenario.boat[agent - 1])
        most_mps = flotilla.derived(own)["LAW_U_MAX"]
        speed_mps, number = fastest(motion, place)
        if speed_mps > most_mps > 0.0:
            yield (
                ("leader", "waypoints"),
                f'"leader.waypoints": at waypoint {number} the slot of boat {agent}, which turns '
                f"with the leader, moves at {speed_mps:.1f} m/s, more than its LAW_U_MAX, "
                f"{most_mps:.1f} m/s: make corner_radius_m greater, speed_mps less, or "
                "formation.turns false",
            )
            return


def _plan_contradictions(scenario: Scenario) -> Iterator[tuple[KeyPath, str]]:
    """Report contradictions of a scenario in which a boat leads."""
    key: KeyPath
    leader = scenario.leader
    if leader.voyage_room_m is not None:
        if leader.boat is None:
            yield (
                ("leader", "voyage_room_m"),
                '"leader.voyage_room_m": needs "leader.boat", which sails it',
            )
        if len(scenario.boat) > 1:
            yield (
                ("leader", "voyage_room_m"),
                '"leader.voyage_room_m": needs a single [[boat]], which measures its hull alone',
            )
    if leader.boat is None:
        return
    if not leader.waypoints:
        yield ("leader", "boat"), '"leader.boat": needs "leader.waypoints", its plan'
    if leader.navigation.model_fields_set:
        key = ("leader", "navigation")
        yield key, '"leader.navigation": boat 1 leads, set [boat.1.navigation] instead'
    own = scenario.boat[leader.boat - 1]
    if any(own.offset_m):
        key = ("boat", str(leader.boat), "offset_m")
        why = "must be [0, 0], as this boat sails the plan itself"
        yield key, f'"{".".join(key)}" = {list(own.offset_m)}: {why}'
    for number, fault in enumerate(scenario.fault, start=1):
        if fault.agent == 0:
            key = ("fault", str(number), "agent")
            yield key, f'"{".".join(key)}" = 0: boat {leader.boat} leads, there is no agent 0'


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
                ticks = f"must be at most rate_hz = {scenario.rate_hz}, that of the world"
                yield (*place, name), f'"{path}.{name}" = {getattr(unit, name)}: {ticks}'
        if unit.attitude_rate_hz and unit.message not in ("local", "global"):
            key = f'"{path}.attitude_rate_hz" = {unit.attitude_rate_hz}'
            yield (*place, "attitude_rate_hz"), f'{key}: "{unit.message}" sends no ATTITUDE'
        if any(unit.origin_m) and unit.message != "local":
            key = f'"{path}.origin_m" = {list(unit.origin_m)}'
            yield (*place, "origin_m"), f'{key}: only "local" has an origin of its own'
