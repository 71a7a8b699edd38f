# SPDX-License-Identifier: MIT
"""The MAVLink parameter protocol as ground stations use it, and the effects of changes."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import Any

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.agent import Agent
from tests.target.bus import FULL_SCALE
from tests.target.course import Course
from tests.target.operator_words import (
    ENTER,
    REAL32,
    drive,
    enter_manual,
    param_list,
    param_read,
    param_set,
)
from tests.target.sea import PAPER, Sea, Tick, acks, at_sea, messages, named, texts
from tests.target.stations import (
    ACCEPTED,
    BOAT,
    DENIED,
    FORMATION,
    GCS,
    GCS_COMPONENT,
    SET_MODE,
    STORAGE,
    TEMPORARILY_REJECTED,
    Station,
    decode,
    float32,
)

LIST: list[dict[str, Any]] = flotilla.parameter_list()
NAMES = [p["name"] for p in LIST]
INDEX = {name: k for k, name in enumerate(NAMES)}
DOES_NOT_EXIST, OUT_OF_RANGE, PERMISSION_DENIED, TYPE_MISMATCH = 1, 2, 3, 7


def values(ticks: list[Tick], link: int = 0) -> list[Any]:
    return named(ticks, "PARAM_VALUE", link)


def assert_right(value: Any, sea: Sea) -> None:
    """Assert that a PARAM_VALUE has the value in force."""
    assert value.param_count == len(LIST)
    assert value.param_id == NAMES[value.param_index]
    assert value.param_type == REAL32
    assert value.param_value == sea.boat.parameters()[value.param_id]
    assert (value.get_srcSystem(), value.get_srcComponent()) == (BOAT, 1)


def set_it(sea: Sea, name: str, value: float, **how: Any) -> list[Tick]:
    sea.say(param_set(name, value), **how)
    return sea.run(0.1)


# The list.


@pytest.mark.parametrize("target", [(BOAT, 1), (BOAT, 0), (0, 0)])
def test_the_list_is_whole_and_in_order(sea: Sea, target: tuple[int, int]) -> None:
    sea.settle()
    sea.say(param_list(target))
    found = values(sea.run(1.0))
    assert [v.param_index for v in found] == list(range(len(LIST)))
    for value in found:
        assert_right(value, sea)
    assert not values(sea.run(2.0))


@pytest.mark.parametrize("target", [(3, 1), (BOAT, 2), (BOAT, 191)])
def test_a_list_requested_of_another_vehicle_is_not_sent(sea: Sea, target: tuple[int, int]) -> None:
    sea.settle()
    sea.say(param_list(target))
    assert not values(sea.run(1.0))


def test_the_list_is_paced_and_other_telemetry_goes_on(sea: Sea) -> None:
    sea.settle()
    sea.say(param_list())
    ticks = sea.run(1.0)
    assert max(len(values([t])) for t in ticks) <= 5
    assert len(named(ticks, "ATTITUDE")) in (10, 11) and named(ticks, "HEARTBEAT")


def test_on_a_slow_link_the_list_keeps_to_its_rate_and_still_ends() -> None:
    sea = Sea({"SR_STATE": 2})
    sea.boat.limit_link(0, 1200)
    sea.settle()
    sea.say(param_list())
    ticks = sea.run(20.0)
    assert sorted(v.param_index for v in values(ticks)) == list(range(len(LIST)))
    size = sum(len(data) for t in ticks for _, data in t.mavlink)
    assert size <= 1200 * 21 and len(named(ticks, "HEARTBEAT")) in (19, 20, 21)


def test_only_the_link_that_asks_gets_the_list() -> None:
    sea = Sea(links=3)
    sea.settle()
    sea.say(param_list(), link=1)
    ticks = sea.run(1.0)
    assert [len(values(ticks, link)) for link in range(3)] == [0, len(LIST), 0]


def test_two_clients_both_get_the_list_and_get_it_again_on_request() -> None:
    sea = Sea(links=2)
    sea.settle()
    for _ in range(2):
        for link in (0, 1):
            sea.say(param_list(), link=link)
        ticks = sea.run(1.0)
        for link in (0, 1):
            assert [v.param_index for v in values(ticks, link)] == list(range(len(LIST)))


def test_a_list_requested_again_while_it_is_sent_is_complete(sea: Sea) -> None:
    sea.settle()
    sea.say(param_list())
    sea.run(0.04)
    sea.say(param_list())
    assert {v.param_index for v in values(sea.run(1.0))} == set(range(len(LIST)))


@pytest.mark.parametrize("seed", range(3))
def test_a_client_can_request_lost_parts_of_the_list(seed: int) -> None:
    rng = random.Random(seed)
    sea = Sea()
    sea.settle()
    sea.say(param_list())
    got: dict[int, Any] = {}
    ticks: list[Tick] = []
    for _ in range(12):
        ticks += sea.run(0.5)
        got |= {v.param_index: v for v in values(ticks) if rng.random() < 0.5}
        ticks = []
        for index in set(range(len(LIST))) - set(got):
            sea.say(param_read(index))
            ticks.append(sea.step())
    assert set(got) == set(range(len(LIST)))


# Single ones.


@pytest.mark.parametrize("name", NAMES)
def test_a_parameter_is_read_by_index_and_by_name(name: str) -> None:
    sea = Sea(links=2)
    sea.step()
    for which in (INDEX[name], name):
        sea.say(param_read(which), link=1)
        ticks = sea.run(0.05)
        (value,) = values(ticks, 1)
        assert value.param_index == INDEX[name]
        assert_right(value, sea)
        assert not values(ticks, 0)


@pytest.mark.parametrize(
    "which",
    [len(LIST), 32767, -2, -32768, "NO_SUCH", "", "law_kx", "LAW_K", "LAW_KXX", "ABCDEFGHIJKLMNOP"],
    ids=str,
)
def test_a_parameter_that_does_not_exist_is_an_error_for_its_asker(
    sea: Sea, which: int | str
) -> None:
    sea.settle()
    sea.say(param_read(which))
    ticks = sea.run(0.2)
    (error,) = named(ticks, "PARAM_ERROR")
    assert error.error == DOES_NOT_EXIST
    assert (error.target_system, error.target_component) == (GCS, GCS_COMPONENT)
    assert error.param_index == (which if isinstance(which, int) else -1)
    assert error.param_id == (which if isinstance(which, str) else "")
    assert not values(ticks)


def test_a_read_by_index_ignores_the_name(sea: Sea) -> None:
    sea.settle()
    sea.say(mavlink.MAVLink_param_request_read_message(BOAT, 1, b"LAW_KX", INDEX["SR_SLOW"]))
    assert [v.param_id for v in values(sea.run(0.1))] == ["SR_SLOW"]


# Setting.


def inside(p: dict[str, Any], value: float) -> bool:
    return bool(p["least"] <= value <= p["greatest"])


def another_value(p: dict[str, Any]) -> float:
    if p["kind"] == "sign":
        return float(-p["default"])
    if p["kind"] in ("frame", "switch"):
        return float(1 - p["default"])
    if p["kind"] == "action":
        return 2.0 - p["default"] if p["default"] != 1 else 0.0
    if p["integer"]:
        step = next(step for step in (2, -2, 1) if inside(p, p["default"] + step))
        return float(p["default"] + step)
    further = p["default"] + 0.1 * (p["greatest"] - p["default"])
    return float32(min(further, p["default"] + 0.05))


CHANGEABLE = [p for p in LIST if p["kind"] != "mode" and p["name"] != "MAV_IDENTITY"]


@pytest.mark.parametrize("p", CHANGEABLE, ids=[p["name"] for p in CHANGEABLE])
def test_a_set_is_reported_on_every_link_with_its_index(p: dict[str, Any]) -> None:
    sea = Sea(links=3)
    sea.settle()
    wanted = another_value(p)
    ticks = set_it(sea, p["name"], wanted, link=1)
    assert sea.boat.parameters()[p["name"]] == wanted
    for link in range(3):
        (value,) = values(ticks, link)
        assert (value.param_id, value.param_index) == (p["name"], INDEX[p["name"]])
        assert value.param_count == len(LIST) and value.param_value == wanted
        assert not named(ticks, "PARAM_ERROR", link)
    assert not texts(ticks)
    assert sea.boat.take_save_request() == "changed"


@dataclass(frozen=True)
class Refusal:
    name: str
    value: float
    error: int
    kind: int = REAL32
    state: str = "DISARMED"


REFUSALS = [
    Refusal("LAW_KX", math.nan, OUT_OF_RANGE),
    Refusal("LAW_KX", math.inf, OUT_OF_RANGE),
    Refusal("LAW_KX", -math.inf, OUT_OF_RANGE),
    Refusal("LAW_KX", 2.001, OUT_OF_RANGE),
    Refusal("LAW_KX", -0.001, OUT_OF_RANGE),
    Refusal("LAW_KX", 2.8e-45, TYPE_MISMATCH, mavlink.MAV_PARAM_TYPE_INT32),
    Refusal("LAW_KX", 1.0, TYPE_MISMATCH, mavlink.MAV_PARAM_TYPE_UINT8),
    Refusal("LAW_KX", 1.0, TYPE_MISMATCH, mavlink.MAV_PARAM_TYPE_REAL64),
    Refusal("LAW_KX", 1.0, TYPE_MISMATCH, 0),
    Refusal("FORM_FRAME", 2.0, OUT_OF_RANGE),
    Refusal("FORM_FRAME", -1.0, OUT_OF_RANGE),
    Refusal("FORM_FRAME", 0.5, OUT_OF_RANGE, state="FORMATION"),
    Refusal("LAW_OBS_BW", 10.001, OUT_OF_RANGE),
    Refusal("LAW_XT_DIST", -1.001, OUT_OF_RANGE),
    Refusal("LAW_CUR_BW", 1.001, OUT_OF_RANGE),
    Refusal("LAW_U_MAX", 20.001, OUT_OF_RANGE),
    Refusal("LAW_R_MAX", math.nan, OUT_OF_RANGE, state="FORMATION"),
    Refusal("FORM_LEADER", 1.5, OUT_OF_RANGE),
    Refusal("FORM_LEADER", 0.0, OUT_OF_RANGE),
    Refusal("FORM_LEADER", 256.0, OUT_OF_RANGE),
    Refusal("FORM_LEADER", float(BOAT), OUT_OF_RANGE),
    Refusal("THR_PORT_DIR", 0.0, OUT_OF_RANGE),
    Refusal("ESC_PORT", 1.0, OUT_OF_RANGE),
    Refusal("THR_DEAD", 20.0, OUT_OF_RANGE),
    Refusal("MAV_IDENTITY", 1.0, OUT_OF_RANGE),
    Refusal("THR_FWD_MAX", 25.0, PERMISSION_DENIED, state="HOLD"),
    Refusal("THR_FWD_MAX", 25.0, PERMISSION_DENIED, state="FORMATION"),
    Refusal("ESC_PORT", 5.0, PERMISSION_DENIED, state="MANUAL"),
    Refusal("MAV_SYSID", 9.0, PERMISSION_DENIED, state="HOLD"),
    Refusal("CAN_NODE", 9.0, PERMISSION_DENIED, state="TEST"),
    Refusal("MAV_GCS_SYSID", 9.0, PERMISSION_DENIED, state="FORMATION"),
    Refusal("FS_ESC_S", 3.0, PERMISSION_DENIED, state="FORMATION"),
]


@pytest.mark.parametrize("r", REFUSALS, ids=str)
def test_a_refused_set_is_reported_as_error_value_and_text(r: Refusal) -> None:
    """MAVSDK needs an error first, QGroundControl the value in force, a human a sentence."""
    sea = Sea(links=2)
    ENTER[r.state](sea)
    sea.run(0.1)
    before = sea.boat.parameters()
    sea.boat.take_save_request()
    sea.say(param_set(r.name, r.value, r.kind), link=1)
    ticks = sea.run(0.15)
    assert sea.boat.parameters() == before
    heard = messages(ticks, 1)
    told = [m.get_type() for m in heard if m.get_type().startswith("PARAM_")]
    assert told == ["PARAM_ERROR", "PARAM_VALUE"]
    (error,) = named(ticks, "PARAM_ERROR", 1)
    assert (error.error, error.param_id) == (r.error, r.name)
    assert error.param_index == INDEX[r.name]
    assert (error.target_system, error.target_component) == (GCS, GCS_COMPONENT)
    for link in (0, 1):
        (value,) = values(ticks, link)
        assert value.param_id == r.name
        assert_right(value, sea)
        assert [m for m in named(ticks, "STATUSTEXT", link) if m.severity <= 4]
    assert not named(ticks, "PARAM_ERROR", 0)
    assert sea.boat.take_save_request() == "none" and sea.state == r.state


def test_the_sentence_of_a_refused_set_names_parameter_and_range(sea: Sea) -> None:
    sea.settle()
    said = "".join(texts(set_it(sea, "LAW_KX", 7.0)))
    assert all(word in said for word in ("LAW_KX", "7", "0", "2"))


def test_setting_an_unknown_parameter_gives_an_error_and_no_value(sea: Sea) -> None:
    sea.settle()
    ticks = set_it(sea, "NO_SUCH", 1.0)
    (error,) = named(ticks, "PARAM_ERROR")
    assert (error.error, error.param_id) == (DOES_NOT_EXIST, "NO_SUCH")
    assert not values(ticks)


def test_a_strangers_set_is_denied_to_him_with_the_value_in_force() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250}, links=2)
    sea.settle()
    ticks = set_it(sea, "FORM_OFS_N", 5.0)
    (error,) = named(ticks, "PARAM_ERROR")
    assert (error.error, error.param_id) == (PERMISSION_DENIED, "FORM_OFS_N")
    for link in (0, 1):
        (value,) = values(ticks, link)
        assert_right(value, sea)
    assert sea.boat.parameters()["FORM_OFS_N"] == 0.0
    assert sea.boat.take_save_request() == "none"
    set_it(sea, "FORM_OFS_N", 5.0, sender=Station(250, 190))
    assert sea.boat.parameters()["FORM_OFS_N"] == 5.0


def test_a_strangers_set_is_also_reported_as_text() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.settle()
    assert any("FORM_OFS_N" in t for t in texts(set_it(sea, "FORM_OFS_N", 5.0)))


def test_a_stranger_too_gets_an_error_for_an_unknown_parameter() -> None:
    """Without an answer it would wait and ask again."""
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.settle()
    assert len(named(set_it(sea, "NO_SUCH", 5.0), "PARAM_ERROR")) == 1


def test_a_stranger_may_read_parameters() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.settle()
    sea.say(param_list())
    assert len(values(sea.run(1.0))) == len(LIST)
    sea.say(param_read("LAW_KX"))
    assert len(values(sea.run(0.1))) == 1


@pytest.mark.parametrize("target", [(3, 1), (BOAT, 7)])
def test_a_set_for_another_vehicle_changes_nothing(sea: Sea, target: tuple[int, int]) -> None:
    sea.settle()
    sea.say(param_set("LAW_KX", 1.0, target=target))
    assert not values(sea.run(0.2)) and sea.boat.parameters()["LAW_KX"] == float32(0.2)


def test_many_sets_at_once_are_all_reported(sea: Sea) -> None:
    """As a ground station loads a parameter file: a few at a time, with repetitions."""
    sea.settle()
    wanted = {p["name"]: another_value(p) for p in CHANGEABLE if p["change"] == "anytime"}
    left = dict(wanted)
    for _ in range(20):
        sea.say(*[param_set(name, value) for name, value in left.items()])
        for value in values(sea.run(0.2)):
            if left.get(value.param_id) == value.param_value:
                del left[value.param_id]
    assert not left
    assert {name: sea.boat.parameters()[name] for name in wanted} == wanted


# When a parameter may change.


@pytest.mark.parametrize("state", ["HOLD", "FORMATION"])
@pytest.mark.parametrize("p", CHANGEABLE, ids=[p["name"] for p in CHANGEABLE])
def test_while_armed_only_parameters_that_may_change_at_any_time_change(
    p: dict[str, Any], state: str
) -> None:
    sea = Sea()
    ENTER[state](sea)
    before = sea.boat.parameters()[p["name"]]
    wanted = another_value(p)
    if wanted == before:
        wanted = before + 1.0
    ticks = set_it(sea, p["name"], wanted)
    allowed = p["change"] == "anytime"
    assert sea.boat.parameters()[p["name"]] == (wanted if allowed else before)
    assert [e.error for e in named(ticks, "PARAM_ERROR")] == (
        [] if allowed else [PERMISSION_DENIED]
    )


def test_setting_the_value_in_force_is_accepted_under_way_and_changes_nothing(sea: Sea) -> None:
    sea.enter_formation()
    ticks = set_it(sea, "THR_FWD_MAX", 20.0)
    (value,) = values(ticks)
    assert value.param_value == 20.0 and not named(ticks, "PARAM_ERROR")
    assert sea.boat.take_save_request() == "none"


@pytest.mark.parametrize("name", ["THR_FWD_MAX", "THR_EXPO"])
def test_a_propellers_parameter_is_in_force_after_disarming(sea: Sea, name: str) -> None:
    enter_manual(sea)
    drive(sea, 500)
    before = sea.commands
    wanted = {"THR_FWD_MAX": 40.0, "THR_EXPO": 1.0}[name]
    set_it(sea, name, wanted)
    drive(sea, 500)
    assert sea.commands == before == pytest.approx((FULL_SCALE / 2,) * 2, abs=1)
    sea.disarm()
    set_it(sea, name, wanted)
    enter_manual(sea)
    drive(sea, 500)
    thrust = {"THR_FWD_MAX": 20.0, "THR_EXPO": 10.0}[name]
    share = {"THR_FWD_MAX": 0.5, "THR_EXPO": math.sqrt(0.5)}[name]
    assert sea.snapshot()["thrust_N"] == pytest.approx({"port": thrust, "stbd": thrust}, abs=0.01)
    assert sea.commands == pytest.approx((FULL_SCALE * share,) * 2, abs=1)


def test_esc_indices_and_directions_are_in_force_after_disarming(sea: Sea) -> None:
    sea.settle()
    for name, value in (("ESC_PORT", 3.0), ("THR_STBD_DIR", -1.0)):
        set_it(sea, name, value)
    sea.escs[0].index = 3
    sea.run(0.5)
    enter_manual(sea)
    drive(sea, 500)
    half = round(FULL_SCALE / 2)
    assert sea.commands == pytest.approx((0, -half, 0, half), abs=1)


def test_a_new_system_id_is_in_force_at_the_next_start(sea: Sea) -> None:
    sea.settle()
    ticks = set_it(sea, "MAV_SYSID", 9.0)
    ticks += sea.run(2.0)
    assert sea.boat.parameters()["MAV_SYSID"] == 9.0
    assert {m.get_srcSystem() for m in messages(ticks)} == {BOAT}
    assert sea.condition("own_fresh")
    sea.arm()
    assert sea.state == "HOLD"
    again = flotilla.Boat(sea.boat.parameters())
    chunks = [data for k in range(200) for _, data in again.tick(k * 10_000).mavlink]
    assert {m.get_srcSystem() for m in decode(chunks)} == {9}


# The mode.


@pytest.mark.parametrize("mode", [0.0, 4.0, 6.0])
def test_an_old_parameter_file_starts_and_stops_no_boat(mode: float) -> None:
    for state, start in (("HOLD", 4), ("FORMATION", FORMATION)):
        sea = Sea()
        sea.enter_hold()
        sea.mode(start)
        ticks = set_it(sea, "MODE", mode)
        assert sea.state == state
        assert [e.error for e in named(ticks, "PARAM_ERROR")] == [DOES_NOT_EXIST]
        assert texts(ticks) == ["MODE is an unknown parameter"]


# Saving.


def test_a_boat_requests_one_save_after_a_change(sea: Sea) -> None:
    sea.settle()
    assert sea.boat.take_save_request() == "none"
    set_it(sea, "LAW_KX", 1.0)
    assert [sea.boat.take_save_request() for _ in range(2)] == ["changed", "none"]
    set_it(sea, "LAW_KX", 1.0)
    set_it(sea, "LAW_KX", 9.0)
    assert sea.boat.take_save_request() == "none"


def test_an_operator_asks_to_save(sea: Sea) -> None:
    sea.settle()
    assert acks(sea.order(STORAGE, 1.0)) == [(STORAGE, ACCEPTED)]
    assert [sea.boat.take_save_request() for _ in range(2)] == ["confirmed", "none"]
    set_it(sea, "LAW_KX", 1.0)
    sea.order(STORAGE, 1.0)
    assert sea.boat.take_save_request() == "confirmed"
    sea.order(STORAGE, 1.0)
    set_it(sea, "LAW_KX", 1.5)
    assert sea.boat.take_save_request() == "confirmed"


@pytest.mark.parametrize("value", [0.0, 2.0, 3.0, -1.0, math.nan])
def test_storage_is_for_saving_only(sea: Sea, value: float) -> None:
    sea.settle()
    assert acks(sea.order(STORAGE, value)) == [(STORAGE, DENIED)]
    assert sea.boat.take_save_request() == "none"


def test_a_stranger_does_not_save() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.settle()
    assert acks(sea.order(STORAGE, 1.0)) == [(STORAGE, DENIED)]
    assert sea.boat.take_save_request() == "none"


# Changes of leader and gains.

NEW = 9


def test_another_leader_is_followed_only_once_it_is_heard_and_asked_for() -> None:
    sea = at_sea({"FS_LEADER_ACT": 0.0})
    sea.say(param_set("FORM_LEADER", float(NEW)))
    tick = sea.step()
    assert sea.state == "HOLD" and tick.commands == (0, 0)
    assert any("leader" in t for t in texts([tick]))
    sea.run(3.0)
    assert sea.state == "HOLD" and not sea.condition("leader_fresh")
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    new = Agent(Station(NEW, 1), Course(3.0, 3.0, 0.4, 0.5), 100_000)
    for k in range(100):
        sea.boat.on_mavlink(new.wire(sea.now_us), sea.now_us)
        sea.step()
        if k > 50:
            assert sea.condition("leader_fresh") and sea.state == "HOLD"
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, ACCEPTED)]
    ahead, starboard, turn = sea.own_course().minus(new.truth(sea.now_us))
    error = sea.snapshot()["error"]
    assert (error["x_m"], error["y_m"], error["psi_rad"]) == pytest.approx(
        (ahead, starboard, turn), abs=0.05
    )


def test_in_coast_another_leader_is_followed_as_soon_as_it_is_heard() -> None:
    sea = at_sea()
    sea.say(param_set("FORM_LEADER", float(NEW)))
    sea.step()
    assert sea.state == "COAST"
    sea.run(1.0)
    assert sea.state == "COAST" and not sea.condition("leader_fresh")
    new = Agent(Station(NEW, 1), Course(3.0, 3.0, 0.4, 0.5), 100_000)
    for _ in range(50):
        sea.boat.on_mavlink(new.wire(sea.now_us), sea.now_us)
        sea.step()
    assert sea.state == "FORMATION"
    ahead, starboard, turn = sea.own_course().minus(new.truth(sea.now_us))
    error = sea.snapshot()["error"]
    assert (error["x_m"], error["y_m"], error["psi_rad"]) == pytest.approx(
        (ahead, starboard, turn), abs=0.05
    )


def test_setting_the_same_leader_again_changes_nothing() -> None:
    sea, other = at_sea(), at_sea()
    set_it(sea, "FORM_LEADER", 1.0)
    other.run(0.1)
    assert sea.state == "FORMATION" and sea.ticks[-1].commands == other.ticks[-1].commands


def test_moving_the_slot_moves_the_error_at_once() -> None:
    # The true motion ignores thrust, so the observer is off.
    sea = Sea(PAPER, own=Course(1.0, 2.0, 0.0), leader=Course(5.0, 5.0, 0.0))
    sea.enter_formation()
    sea.run(0.5)
    before = sea.snapshot()["error"]
    set_it(sea, "FORM_OFS_N", 2.0)
    set_it(sea, "FORM_OFS_E", -3.0)
    after = sea.snapshot()["error"]
    assert after["x_m"] - before["x_m"] == pytest.approx(-2.0, abs=0.01)
    assert after["y_m"] - before["y_m"] == pytest.approx(3.0, abs=0.01)
    assert sea.state == "FORMATION"


def test_a_new_gain_is_in_force_under_way() -> None:
    """u* = u_L − k_x e_x, the leader at rest, boat and leader heading north."""
    sea = Sea(own=Course(1.0, 2.0, 0.0), leader=Course(3.0, 2.0, 0.0))
    sea.enter_formation()
    sea.run(0.5)
    for k_x in (0.2, 0.5, 0.1, 0.0):
        set_it(sea, "LAW_KX", k_x)
        seen = sea.snapshot()
        assert sea.state == "FORMATION"
        assert seen["virtual_velocity"]["u_mps"] == pytest.approx(
            -k_x * seen["error"]["x_m"], abs=1e-4
        )


def test_the_rate_of_the_state_changes_at_once(sea: Sea) -> None:
    sea.enter_formation()
    for rate in (20, 5):
        set_it(sea, "SR_STATE", float(rate))
        assert len(named(sea.run(2.0), "ATTITUDE")) in range(2 * rate - 1, 2 * rate + 2)
    set_it(sea, "SR_STATE", 0.0)
    assert not named(sea.run(2.0), "ATTITUDE")
