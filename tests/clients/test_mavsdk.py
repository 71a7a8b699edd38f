# SPDX-License-Identifier: MIT
"""A MAVSDK script finds a boat, tunes it, arms it and reads its telemetry."""

import math
import tomllib
from collections.abc import Callable
from enum import IntEnum
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import flotilla
import pytest
from mavsdk import Autopilot
from mavsdk.exceptions import MavsdkError
from mavsdk.plugins.action.action import ActionError, ActionResult
from mavsdk.plugins.component_metadata.component_metadata import MetadataType
from mavsdk.plugins.follow_me import FollowMe
from mavsdk.plugins.follow_me.follow_me import FollowMeError, FollowMeResult
from mavsdk.plugins.ftp.ftp import FtpResult
from mavsdk.plugins.log_files import LogFiles
from mavsdk.plugins.log_files.log_files import LogFilesError, LogFilesResult
from mavsdk.plugins.mission import Mission
from mavsdk.plugins.mission.mission import MissionResult
from mavsdk.plugins.offboard import Offboard
from mavsdk.plugins.offboard.offboard import OffboardResult, VelocityNedYaw
from mavsdk.plugins.param.param import ParamError, ParamResult
from mavsdk.plugins.telemetry import FixType, FlightMode

from tests.clients.boat import BOTH_IDENTITIES, ESCS_SILENT, OWN_STATE_STALE, Sea, parameters
from tests.clients.mavsdk_client import MavsdkClient
from tests.linux.process import ROOT
from tests.target.course import BEHIND, Course
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    DENIED,
    FORCE,
    FORMATION,
    HOLD,
    ORIGIN,
    SET_MODE,
    TEMPORARILY_REJECTED,
)
from tests.turns import some

REQUEST_MESSAGE = 512
AVAILABLE_MODES, CURRENT_MODE = 435, 436
SET_INTERVAL = 511
CIRCLING = Course(1.0, 2.0, 0.3, 0.5, 0.0, 0.2)


def silence_escs(sea: Sea) -> None:
    sea.escs_on = False


def silence_navigation(sea: Sea) -> None:
    sea.own.on = False


# -- found


@BOTH_IDENTITIES
def test_a_boat_is_found_as_an_autopilot_of_its_system_id(
    mavsdk: MavsdkClient, autopilot: float
) -> None:
    assert mavsdk.system.get_system_id() == BOAT
    assert mavsdk.system.has_autopilot()
    said = Autopilot.ARDUPILOT if autopilot else Autopilot.GENERIC
    assert mavsdk.system.autopilot_type() == said
    assert mavsdk.system.component_ids() == [1]


@BOTH_IDENTITIES
def test_a_boats_version_is_the_projects(mavsdk: MavsdkClient) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    version = mavsdk.call(mavsdk.info.get_version)
    assert f"{version.flight_sw_major}.{version.flight_sw_minor}" == project["version"]


# -- parameters


def test_all_parameters_listed_are_the_boats(mavsdk: MavsdkClient) -> None:
    listed = mavsdk.call(mavsdk.param.get_all_params)
    assert listed.int_params == listed.custom_params == []
    assert {each.name: each.value for each in listed.float_params} == parameters()


def test_a_parameter_is_set_read_back_and_the_boat_has_it(sea: Sea, mavsdk: MavsdkClient) -> None:
    mavsdk.call(mavsdk.param.set_param_float, "LAW_KX", 0.75)
    assert mavsdk.call(mavsdk.param.get_param_float, "LAW_KX") == 0.75
    assert sea.asked("LAW_KX") == 0.75


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("LAW_KX", 2.5, ParamResult.VALUE_OUT_OF_RANGE),
        ("LAW_KX", -0.1, ParamResult.VALUE_OUT_OF_RANGE),
        ("LAW_KX", math.nan, ParamResult.VALUE_OUT_OF_RANGE),
        ("LAW_KX", math.inf, ParamResult.VALUE_OUT_OF_RANGE),
        ("THR_PORT_DIR", 0.0, ParamResult.VALUE_OUT_OF_RANGE),
        ("NO_SUCH_NAME", 1.0, ParamResult.DOES_NOT_EXIST),
    ],
)
def test_a_bad_value_is_refused_with_the_reason_and_changes_nothing(
    sea: Sea, mavsdk: MavsdkClient, name: str, value: float, reason: ParamResult
) -> None:
    with pytest.raises(ParamError) as refusal:
        mavsdk.call(mavsdk.param.set_param_float, name, value)
    assert refusal.value.result == reason  # a refusal that is not heard ends as TIMEOUT
    if name in parameters():
        assert mavsdk.call(mavsdk.param.get_param_float, name) == parameters()[name]
        assert sea.asked(name) == parameters()[name]


def test_the_propellers_are_not_turned_round_while_the_boat_is_armed(
    sea: Sea, mavsdk: MavsdkClient
) -> None:
    sea.arm()
    with pytest.raises(ParamError) as refusal:
        mavsdk.call(mavsdk.param.set_param_float, "THR_PORT_DIR", -1.0)
    assert refusal.value.result == ParamResult.PERMISSION_DENIED
    mavsdk.call(mavsdk.action.disarm)
    mavsdk.call(mavsdk.param.set_param_float, "THR_PORT_DIR", -1.0)
    assert sea.asked("THR_PORT_DIR") == -1.0


# -- arming


@pytest.mark.usefixtures("escs_silent")
def test_arming_is_refused_with_the_reason_and_works_once_it_is_gone(
    sea: Sea, mavsdk: MavsdkClient
) -> None:
    armed = mavsdk.watch("armed")
    with pytest.raises(ActionError) as refusal:
        mavsdk.call(mavsdk.action.arm)
    assert refusal.value.result == ActionResult.COMMAND_DENIED
    sea.until(lambda: ESCS_SILENT in mavsdk.texts)
    assert not sea.ever_armed

    sea.escs_on = True
    sea.until(lambda: sea.armable)
    mavsdk.call(mavsdk.action.arm)
    sea.until(lambda: sea.armed and armed[-1:] == [True])
    mavsdk.call(mavsdk.action.disarm)
    sea.until(lambda: not sea.armed and armed[-1:] == [False])


def test_a_boat_without_navigation_is_armed_for_manual_only(sea: Sea, mavsdk: MavsdkClient) -> None:
    sea.until(lambda: sea.armable)
    silence_navigation(sea)
    sea.until(lambda: not sea.armable)
    assert mavsdk.command(ARM, 1.0) == ACCEPTED
    sea.until(lambda: OWN_STATE_STALE in mavsdk.texts)
    sea.until(lambda: sea.armed)
    assert set(sea.raw_commands()[-100:]) == {(0, 0)}


def test_no_force_arms_against_a_failing_check(sea: Sea, mavsdk: MavsdkClient) -> None:
    sea.until(lambda: sea.armable)
    assert mavsdk.command(ARM, 1.0, FORCE) == ACCEPTED  # where no check fails it is an ARM
    sea.until(lambda: sea.armed)
    mavsdk.call(mavsdk.action.disarm)
    sea.until(lambda: not sea.armed)

    silence_escs(sea)
    sea.until(lambda: not sea.armable)
    before = len(sea.named("HEARTBEAT"))
    assert mavsdk.command(ARM, 1.0, FORCE) == TEMPORARILY_REJECTED
    sea.until(lambda: ESCS_SILENT in mavsdk.texts)
    mavsdk.call(mavsdk.action.arm_force)  # which MAVSDK sends as a DISARM with the force number
    for params in ((FORCE,), (1.0, 1.0), (2.0, FORCE)):
        assert mavsdk.command(ARM, *params) == DENIED
    sea.beat()
    beats = sea.named("HEARTBEAT")[before:]
    assert not any(beat.base_mode & 128 for beat in some(beats))
    assert set(sea.raw_commands()[-100:]) == {(0, 0)}


# -- what it says


@BOTH_IDENTITIES
def test_health_follows_the_freshness_of_the_own_state_both_ways(
    sea: Sea, mavsdk: MavsdkClient
) -> None:
    healthy, health = mavsdk.watch("health_all_ok"), mavsdk.watch("health")
    for on in (True, False, True):
        sea.own.on = on
        sea.until(lambda on=on: healthy[-1:] == [on] and health[-1].is_armable == on)


def test_a_boat_at_rest_is_where_its_navigation_unit_says(sea: Sea, mavsdk: MavsdkClient) -> None:
    names = ("position", "velocity_ned", "attitude_euler", "home", "position_velocity_ned")
    said = {name: mavsdk.watch(name) for name in names}
    sea.until(lambda: all(said.values()))
    degree_m = math.pi / 180 * 6_371_000
    north, east = sea.own.course.north, sea.own.course.east
    latitude = 1e-7 * ORIGIN[0] + north / degree_m
    longitude = 1e-7 * ORIGIN[1] + east / degree_m / math.cos(math.radians(latitude))
    position, velocity = said["position"][-1], said["velocity_ned"][-1]
    assert position.latitude_deg == pytest.approx(latitude, abs=3e-7)
    assert position.longitude_deg == pytest.approx(longitude, abs=3e-7)
    assert position.absolute_altitude_m == pytest.approx(1e-3 * ORIGIN[2], abs=0.01)
    assert math.hypot(velocity.north_m_s, velocity.east_m_s) == 0.0
    assert said["attitude_euler"][-1].yaw_deg == pytest.approx(math.degrees(0.3), abs=1e-3)
    local = said["position_velocity_ned"][-1].position
    assert (local.north_m, local.east_m) == pytest.approx((north, east), abs=1e-3)
    home = said["home"][-1]
    assert home.latitude_deg == pytest.approx(latitude, abs=1e-4)
    assert home.longitude_deg == pytest.approx(longitude, abs=1e-4)


def test_a_circling_boat_has_its_speed_along_the_circle(sea: Sea, mavsdk: MavsdkClient) -> None:
    sea.own.course = CIRCLING
    speed, turn = CIRCLING.u, CIRCLING.r
    centre_north = CIRCLING.north - speed / turn * math.sin(CIRCLING.psi)
    centre_east = CIRCLING.east + speed / turn * math.cos(CIRCLING.psi)
    local, globally = mavsdk.watch("position_velocity_ned"), mavsdk.watch("velocity_ned")

    def on_the_circle() -> bool:
        place, velocity = local[-1].position, local[-1].velocity
        north, east = place.north_m - centre_north, place.east_m - centre_east
        return (
            velocity.north_m_s == pytest.approx(-turn * east, abs=0.02)
            and velocity.east_m_s == pytest.approx(turn * north, abs=0.02)
            and math.hypot(north, east) == pytest.approx(speed / turn, abs=0.1)
        )

    sea.until(lambda: local and on_the_circle())
    sea.until(
        lambda: (
            globally
            and math.hypot(globally[-1].north_m_s, globally[-1].east_m_s)
            == pytest.approx(speed, abs=0.02)
        )
    )


def test_the_units_fix_is_shown(sea: Sea, mavsdk: MavsdkClient) -> None:
    told, raw = mavsdk.watch("gps_info"), mavsdk.watch("raw_gps")
    sea.own.tells_fix = True
    sea.until(lambda: told and raw and told[-1].num_satellites)
    assert (told[-1].fix_type, told[-1].num_satellites) == (FixType.FIX_3D, 9)
    assert raw[-1].latitude_deg == pytest.approx(1e-7 * ORIGIN[0])


def intervals_ms(messages: list[Any]) -> list[int]:
    stamps = [m["time_boot_ms"] if isinstance(m, dict) else m.time_boot_ms for m in messages]
    return [b - a for a, b in pairwise(stamps)]


def test_rates_are_set_for_the_askers_link_alone(sea: Sea, mavsdk: MavsdkClient) -> None:
    heard = mavsdk.messages("ATTITUDE")

    def comes_every(ms: float) -> bool:
        return len(heard) > 5 and median(intervals_ms(heard[-6:])) == pytest.approx(ms, rel=0.3)

    sea.until(lambda: comes_every(100))
    for rate_Hz in (2.5, 20.0):
        mavsdk.call(mavsdk.telemetry.set_rate_attitude_euler, rate_Hz)
        sea.until(lambda ms=1000 / rate_Hz: comes_every(ms))
    others = intervals_ms(sea.named("ATTITUDE", 0))
    assert median(others) == pytest.approx(100, rel=0.3), sea.words


# -- modes


@BOTH_IDENTITIES
def test_the_modes_are_listed_by_name(sea: Sea, mavsdk: MavsdkClient) -> None:
    heard = mavsdk.messages("AVAILABLE_MODES")
    assert mavsdk.command(REQUEST_MESSAGE, AVAILABLE_MODES, 0.0) == ACCEPTED
    sea.until(lambda: heard and len(heard) >= heard[0]["number_modes"])
    assert [mode["mode_index"] for mode in heard] == list(range(1, len(heard) + 1))
    names = {mode["custom_mode"]: mode["mode_name"] for mode in heard}
    assert len(names) == len(heard)
    assert names[0] == "MANUAL"
    assert names[HOLD] == "HOLD"
    assert "FORMATION" in names[FORMATION] or "FOLLOW" in names[FORMATION]


@BOTH_IDENTITIES
def test_hold_of_mavsdk_stops_a_boat_in_formation(sea: Sea, mavsdk: MavsdkClient) -> None:
    modes = mavsdk.messages("CURRENT_MODE")
    assert mavsdk.command(SET_INTERVAL, float(CURRENT_MODE), 1e6) == ACCEPTED
    sea.until(lambda: sea.armable)
    mavsdk.call(mavsdk.action.arm)
    assert mavsdk.command(SET_MODE, 1.0, FORMATION) == ACCEPTED
    sea.until(lambda: sea.state == "FORMATION" and sea.driven())
    sea.until(lambda: modes and modes[-1]["custom_mode"] == FORMATION)
    mavsdk.call(mavsdk.action.hold)
    sea.until(lambda: sea.state == "HOLD" and not sea.driven())
    sea.until(lambda: modes[-1]["custom_mode"] == HOLD)


def px4_calls(mavsdk: MavsdkClient) -> dict[str, tuple[Callable[..., Any], IntEnum]]:
    """MAVSDK's calls for a PX4 autopilot, and how each must fail."""
    action, system = mavsdk.action, mavsdk.system
    offboard, denied = Offboard(system), ActionResult.COMMAND_DENIED
    mavsdk.call(offboard.set_velocity_ned, VelocityNedYaw(1.0, 0.0, 0.0, 0.0))
    return {
        "offboard": (offboard.start, OffboardResult.COMMAND_DENIED),
        "goto": (lambda: action.goto_location(47.4, 8.5, 490.0, 0.0), denied),  # 3 km away
        "takeoff": (action.takeoff, ActionResult.UNSUPPORTED),
        "mission": (Mission(system).start_mission, MissionResult.DENIED),
        "follow": (FollowMe(system).start, FollowMeResult.COMMAND_DENIED),
    }


@pytest.mark.parametrize("state", ["HOLD", "FORMATION"])
def test_px4_requests_are_refused_and_change_nothing(
    sea: Sea, mavsdk: MavsdkClient, state: str
) -> None:
    sea.own.course = BEHIND
    sea.beat()  # it may have heard its unit elsewhere: a jump, which its checks show by then
    sea.until(lambda: sea.armable)
    mavsdk.call(mavsdk.action.arm)
    if state == "FORMATION":
        assert mavsdk.command(SET_MODE, 1.0, FORMATION) == ACCEPTED
        sea.until(lambda: sea.state == "FORMATION" and sea.driven())
    before = len(sea.raw_commands())
    for name, (ask, result) in px4_calls(mavsdk).items():
        with pytest.raises(MavsdkError) as refusal:
            mavsdk.call(ask)
        assert refusal.value.result == result, name
        sea.beat()
        assert sea.state == state, name
    assert "Refused: mode 6 of a PX4 client is OFFBOARD" in mavsdk.texts
    if state == "HOLD":
        assert set(some(sea.raw_commands()[before:])) == {(0, 0)}


@BOTH_IDENTITIES
def test_goto_and_return_of_mavsdk(sea: Sea, mavsdk: MavsdkClient) -> None:
    places = mavsdk.watch("position")
    sea.until(lambda: sea.armable and places)
    here = places[-1]
    mavsdk.call(mavsdk.action.arm)
    north = here.latitude_deg + 1e-4  # 11 m
    mavsdk.call(mavsdk.action.goto_location, north, here.longitude_deg, 490.0, math.nan)
    sea.until(lambda: sea.state == "GUIDED" and sea.driven())
    mavsdk.call(mavsdk.action.return_to_launch)
    sea.until(lambda: sea.state == "RTL")
    mavsdk.call(mavsdk.action.hold)
    sea.until(lambda: sea.state == "HOLD" and not sea.driven())


@pytest.mark.parametrize("autopilot", [1.0])
def test_a_boat_with_ardupilots_identity_shows_its_modes_and_is_driven_by_velocities(
    sea: Sea, mavsdk: MavsdkClient
) -> None:
    shown = mavsdk.watch("flight_mode")
    offboard = Offboard(mavsdk.system)
    sea.until(lambda: sea.armable)
    mavsdk.call(mavsdk.action.arm)
    mavsdk.call(offboard.set_velocity_ned, VelocityNedYaw(0.4, 0.0, 0.0, 0.0))
    mavsdk.call(offboard.start)
    sea.until(lambda: sea.state == "GUIDED" and sea.driven())
    sea.until(lambda: shown[-1:] == [FlightMode.OFFBOARD])
    mavsdk.call(offboard.stop)
    sea.until(lambda: sea.state == "HOLD" and shown[-1] == FlightMode.HOLD)
    with pytest.raises(FollowMeError):
        mavsdk.call(FollowMe(mavsdk.system).start)
    assert sea.state == "HOLD"


# -- files


def test_there_are_no_logs_to_download(mavsdk: MavsdkClient) -> None:
    with pytest.raises(LogFilesError) as refusal:
        mavsdk.call(LogFiles(mavsdk.system).get_entries)
    assert refusal.value.result == LogFilesResult.NO_LOGFILES


def test_the_metadata_is_downloaded_and_is_the_firmwares(
    sea: Sea, mavsdk: MavsdkClient, home: Path
) -> None:
    come: list[MetadataType] = []
    mavsdk.metadata.subscribe_metadata_available(lambda update, _: come.append(update.type))
    mavsdk.metadata.request_autopilot_component()
    sea.until(lambda: MetadataType.ALL_COMPLETED in come)
    got = mavsdk.call(mavsdk.metadata.get_metadata, 1, MetadataType.PARAMETER)
    assert got.json_metadata.encode() == flotilla.metadata()["parameters.json"]
    assert list(home.rglob("compid*"))  # cached here, in a new folder


@pytest.mark.parametrize("burst", [False, True])
@pytest.mark.parametrize("name", ["general.json", "parameters.json"])
def test_a_file_is_downloaded_as_it_is(
    sea: Sea, mavsdk: MavsdkClient, home: Path, name: str, burst: bool
) -> None:
    results: list[FtpResult] = []
    mavsdk.ftp.download_async(
        f"/{name}", str(home), burst, lambda result, *_: results.append(result)
    )
    sea.until(lambda: results and results[-1] != FtpResult.NEXT)
    assert results[-1] == FtpResult.SUCCESS, sea.words
    assert (home / name).read_bytes() == flotilla.metadata()[name]


def test_the_files_are_listed(mavsdk: MavsdkClient) -> None:
    listed = mavsdk.call(mavsdk.ftp.list_directory, "/")
    assert {entry.name for entry in listed.entries} >= set(flotilla.metadata())
