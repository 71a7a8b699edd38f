# SPDX-License-Identifier: MIT
"""Faults around a fleet's boats, seen on their wires."""

from __future__ import annotations

import math
import re
from typing import Any

import flotilla
import numpy as np
import pytest

from sil.scenario.fault_kinds import KINDS
from tests.target.bus import ESC_STATUS, NODE_STATUS, of_type, transfers, type_of
from tests.target.troubled_fleet import NAVIGATION, RADIO, Troubled, frames, heard, messages, said
from tests.target.twin_fleets import H_US

PORT, STBD = 21, 22
HOUR_S = 3600.0
LONG_AGO = (10**10, 0.0)  # a clock that can be set back by an hour and stay positive


def positions(records: Any, agent: int, link: int = NAVIGATION) -> list[Any]:
    return messages(heard(records, agent, link), "LOCAL_POSITION_NED")


# -- the navigation unit


def test_a_silent_unit_sends_nothing_and_resumes_afterwards() -> None:
    sea = Troubled()
    sea.fail(1, "own_silent")
    assert heard(sea.sail(100), 1, NAVIGATION) == []
    assert not sea.conditions(1)["own_fresh"] and sea.conditions(2)["own_fresh"]
    sea.heal(1, "own_silent")
    assert len(positions(sea.sail(100), 1)) == 100


def test_a_frozen_unit_repeats_its_state_with_new_stamps() -> None:
    sea = Troubled()
    sea.fail(1, "own_frozen")
    told = positions(sea.sail(50), 1)
    assert len({(m.x, m.y, m.vx, m.vy) for m in told}) == 1
    assert [m.time_boot_ms for m in told] == sorted({m.time_boot_ms for m in told})
    sea.heal(1, "own_frozen")
    assert len({m.x for m in positions(sea.sail(50), 1)}) == 50


def test_a_stuck_unit_repeats_its_position_with_true_heading_and_no_speed() -> None:
    sea, well = Troubled(), Troubled()
    sea.fail(1, "own_stuck")
    records, true = sea.sail(2), well.sail(2)
    assert len({(m.x, m.y, m.vx, m.vy) for m in positions(records, 1)}) == 1
    assert positions(records, 1)[0].vx == 0.0 != positions(true, 1)[0].vx
    told, right = (messages(heard(each, 1, NAVIGATION), "ATTITUDE") for each in (records, true))
    assert len({m.yaw for m in told}) == 2
    assert (told[0].yaw, told[0].yawspeed) == (right[0].yaw, right[0].yawspeed)


@pytest.mark.parametrize("metres", [5.0, -30.0])
def test_a_unit_that_jumps_reports_a_position_that_far_north(metres: float) -> None:
    well, ill = Troubled(), Troubled()
    ill.fail(1, "own_jump", value=metres)
    (true, *_), (told, *_) = (positions(sea.sail(1), 1) for sea in (well, ill))
    assert (told.x, told.y, told.vx) == (pytest.approx(true.x + metres), true.y, true.vx)


@pytest.mark.parametrize("metres", [100.0, -100.0])
def test_a_unit_that_reports_degrees_jumps_by_the_same_distance(metres: float) -> None:
    def latitude(by: float) -> int:
        fleet = flotilla.Fleet(record=True)
        fleet.add_leader(0, 100, (100.0, "global", 0.0), (0, 0.0))
        fleet.set_fault(0, "own_jump", 0, value=by)
        still = np.zeros((1, 3))
        place = np.array([[487_000_000, 22_950_000]], np.int32)
        fleet.tick(0, still, still, place, np.zeros((0, 2)), np.zeros((0, 2)))
        (message,) = messages([(0, fleet.sent(0))], "GLOBAL_POSITION_INT")
        return int(message.lat)

    moved = 1e-7 * (latitude(metres) - latitude(0.0)) * math.pi / 180 * 6_371_000
    assert moved == pytest.approx(metres, rel=0.005)


@pytest.mark.parametrize("ahead_s", [HOUR_S, -HOUR_S])
def test_a_fault_of_a_units_clock_shifts_its_time_stamps_alone(ahead_s: float) -> None:
    well, ill = Troubled(LONG_AGO), Troubled(LONG_AGO)
    ill.fail(1, "own_clock", value=ahead_s)
    (true, *_), (told, *_) = (positions(sea.sail(1), 1) for sea in (well, ill))
    assert told.time_boot_ms - true.time_boot_ms == 1000 * ahead_s
    assert told.x == true.x


def test_a_unit_reports_a_poor_fix_and_then_a_good_one() -> None:
    sea = Troubled()
    sea.fail(1, "own_poor_fix")
    told = messages(heard(sea.sail(100), 1, NAVIGATION), "GPS_RAW_INT")
    assert {(m.fix_type, m.satellites_visible) for m in told} == {(1, 0)} and len(told) == 5
    assert not sea.conditions(1)["own_good"] and sea.conditions(2)["own_good"]
    sea.heal(1, "own_poor_fix")
    told = messages(heard(sea.sail(100), 1, NAVIGATION), "GPS_RAW_INT")
    assert {(m.fix_type, m.eph) for m in told} == {(3, 80)}
    assert not sea.conditions(1)["own_good"]  # for another second after the first good fix
    sea.tick(30)
    assert sea.conditions(1)["own_good"]


def test_a_unit_reports_a_poor_estimate_once_and_then_an_unknown_one() -> None:
    sea = Troubled()
    sea.fail(1, "own_poor_estimate")
    first, *others = messages(heard(sea.sail(100), 1, NAVIGATION), "ESTIMATOR_STATUS")
    assert first.pos_horiz_accuracy == 500.0 and first.flags == 0x3F and len(others) == 4
    assert all(math.isnan(m.pos_horiz_accuracy) for m in others)
    assert not sea.conditions(1)["own_good"] and sea.conditions(2)["own_good"]
    sea.heal(1, "own_poor_estimate")
    (good, *_) = messages(heard(sea.sail(120), 1, NAVIGATION), "ESTIMATOR_STATUS")
    assert good.pos_horiz_accuracy == 0.5 and good.vel_ratio == pytest.approx(0.1)
    assert sea.conditions(1)["own_good"]


@pytest.mark.parametrize("agent", [0, 1])
def test_a_second_kind_of_message_repeats_the_state_later(agent: int) -> None:
    sea = Troubled()
    sea.fail(agent, "own_late_kind", value=0.5)
    link = NAVIGATION if agent else RADIO
    wire = heard(sea.sail(100), 1, link)
    who = 1 if agent else 100
    late = [m for m in messages(wire, "ODOMETRY") if m.get_srcSystem() == who]
    prompt = {m.time_boot_ms: m for m in positions_of(wire, who)}
    assert len(late) in (49, 50) and len(prompt) == 100
    assert all(m.x == prompt[m.time_usec // 1000].x for m in late)
    assert sea.state(1) == "FORMATION"


def positions_of(wire: list[tuple[int, bytes]], system: int) -> list[Any]:
    return [m for m in messages(wire, "LOCAL_POSITION_NED") if m.get_srcSystem() == system]


def test_a_second_unit_with_a_lower_component_is_ignored() -> None:
    sea, well = Troubled(), Troubled()
    sea.fail(1, "own_impostor", value=300.0)
    told = positions(sea.sail(100), 1)
    north = {c: [m.x for m in told if m.get_srcComponent() == c] for c in (191, 220)}
    assert len(north[191]) == len(north[220]) == 100
    assert north[191][0] == pytest.approx(north[220][0] + 300.0, abs=0.05)
    well.tick(100)
    assert sea.state(1) == "FORMATION" and sea.commands.tolist() == well.commands.tolist()


def test_a_pilots_receiver_reports_switch_and_throttle_and_neutral_afterwards() -> None:
    sea = Troubled()
    sea.fail(1, "pilot", value=-0.5)
    (told, *_) = messages(heard(sea.sail(20), 1, NAVIGATION), "RC_CHANNELS")
    assert (told.chancount, told.chan1_raw, told.chan3_raw, told.chan7_raw) == (
        16,
        1500,
        1300,
        1900,
    )
    sea.heal(1, "pilot")
    (told, *_) = messages(heard(sea.sail(20), 1, NAVIGATION), "RC_CHANNELS")
    assert (told.chan3_raw, told.chan7_raw) == (1500, 1100)


# -- the ESCs


def test_a_silent_esc_turns_until_the_boat_is_in_fault() -> None:
    sea = Troubled()
    sea.fail(1, "esc_silent", esc="port")
    nodes = {type_of(can_id)[2] for can_id, _ in frames(sea.sail(100), 1, to_boat=True)}
    assert nodes == {STBD}
    assert sea.commands[0].all()
    sea.tick(100)
    assert sea.state(1) == "FAULT" and not sea.commands[0].any()


def test_a_stuck_esc_ignores_commands() -> None:
    sea = Troubled()
    port = sea.commands[0, 0]
    sea.fail(1, "esc_stuck", esc="port")
    sea.fleet.command([1], sea.t_us, 400, (0.0,))
    sea.tick(100)
    assert sea.state(1) == "DISARMED"
    assert sea.commands[0].tolist() == [port, 0.0] and port != 0.0
    sea.heal(1, "esc_stuck")
    sea.tick()
    assert not sea.commands[0].any()


def test_a_reversed_esc_turns_and_reports_the_other_way() -> None:
    well, ill = Troubled(), Troubled()
    ill.fail(1, "esc_reversed", esc="stbd")
    (port, stbd), (ill_port, ill_stbd) = (rpms(sea.sail(5)) for sea in (well, ill))
    assert (ill_port, ill_stbd) == (port, -stbd)
    one, other = Troubled(), Troubled()
    other.fail(1, "esc_reversed", esc="stbd")
    for sea in (one, other):
        sea.tick()
    assert other.commands[0].tolist() == [one.commands[0, 0], -one.commands[0, 1]]
    assert one.commands[0, 1] != 0.0


def rpms(records: Any) -> list[int]:
    status = transfers(of_type(frames(records, 1, to_boat=True), ESC_STATUS))
    return [t.payload.rpm for t in status[:2]]


def test_an_esc_that_reboots_is_silent_and_needs_a_zero_before_it_turns() -> None:
    sea = Troubled()
    sea.fail(1, "esc_reboot", esc="port")
    records = sea.sail(50)
    assert {type_of(can_id)[2] for can_id, _ in frames(records, 1, to_boat=True)} == {STBD}
    assert sea.commands[0, 0] == 0.0 != sea.commands[0, 1]
    sea.heal(1, "esc_reboot")
    sea.tick(2)
    assert sea.commands[0, 0] == 0.0  # the boat has not said zero
    beats = of_type(frames(sea.sail(110), 1, to_boat=True), NODE_STATUS)
    uptimes = {t.source_node_id: t.payload.uptime_sec for t in transfers(beats)}
    assert uptimes[PORT] <= 2 < uptimes[STBD]
    assert sea.state(1) == "FAULT"


@pytest.mark.parametrize("volts", [20.0, 0.0, 25.5])
def test_a_fault_changes_the_voltage_that_one_esc_reports(volts: float) -> None:
    sea = Troubled()
    sea.fail(1, "esc_voltage", value=volts, esc="stbd")
    told = transfers(of_type(frames(sea.sail(50), 1, to_boat=True), ESC_STATUS))
    assert {(t.source_node_id, t.payload.voltage) for t in told} == {(PORT, 24.0), (STBD, volts)}
    sea.heal(1, "esc_voltage")
    told = transfers(of_type(frames(sea.sail(50), 1, to_boat=True), ESC_STATUS))
    assert {t.payload.voltage for t in told} == {24.0}


# -- the bus


def test_a_bus_that_is_off_carries_no_frames_and_is_reported_down() -> None:
    sea = Troubled()
    sea.fail(1, "bus_off")
    records = sea.sail(1)
    assert not sea.conditions(1)["bus_up"] and sea.state(1) == "FAULT"
    records += sea.sail(99)
    assert frames(records, 1, to_boat=True) == []
    assert not sea.commands[0].any()
    sea.heal(1, "bus_off")
    assert frames(sea.sail(100), 1, to_boat=True)
    assert sea.conditions(1)["bus_up"]


@pytest.mark.parametrize("share", [0.0, 0.1, 1.0])
def test_a_bus_loses_the_given_share_of_frames(share: float) -> None:
    well, ill = Troubled(), Troubled()
    ill.fail(1, "frame_loss", value=share, seed=6)
    sent, come = (len(frames(sea.sail(400), 1, to_boat=True)) for sea in (well, ill))
    assert come / sent == pytest.approx(1.0 - share, abs=0.04)
    assert (sea_moves(ill) == 0.0) == (share == 1.0)


def sea_moves(sea: Troubled) -> float:
    return float(abs(sea.commands[0]).max())


def test_a_stop_switch_on_the_bus_stops_the_boat_until_it_is_disarmed() -> None:
    sea = Troubled()
    sea.fail(1, "stop_switch")
    sea.tick(20)
    assert not sea.commands[0].any() and sea.commands[1].any()
    sea.fleet.command([1], sea.t_us, 176, (1.0, 6.0))
    sea.heal(1, "stop_switch")
    sea.tick(100)
    assert not sea.commands[0].any() and sea.state(1) != "FORMATION"


# -- the radio


def test_a_silent_radio_neither_sends_nor_hears() -> None:
    sea = Troubled()
    sea.fail(1, "radio_silent")
    records = sea.sail(50)
    assert heard(records, 1, RADIO) == [] == heard(records, 2, RADIO)
    assert said(records, 1)  # the boat does not know
    sea.fleet.command([1], sea.t_us, 400, (0.0,))
    sea.tick(5)
    assert sea.state(1) != "DISARMED"


def test_followers_of_a_leader_with_a_silent_radio_still_hear_each_other() -> None:
    sea = Troubled()
    sea.fail(0, "radio_silent")
    records = sea.sail(50)
    assert {m.get_srcSystem() for m in messages(heard(records, 1, RADIO), "ATTITUDE")} == {2}


def test_a_radio_loses_the_given_share_of_chunks() -> None:
    sea = Troubled()
    sea.fail(1, "radio_loss", value=0.3, seed=9)
    records = sea.sail(500)
    spoken, come = said(records, 1), heard(records, 2, RADIO)
    assert set(come) < set(spoken)
    assert len(come) / len(spoken) == pytest.approx(0.7, abs=0.08)


def test_a_radio_damages_the_given_share_of_bytes() -> None:
    sea = Troubled()
    sea.fail(1, "byte_errors", value=0.05, seed=9)
    records = sea.sail(400)
    spoken, come = dict(said(records, 1)), dict(heard(records, 2, RADIO))
    assert spoken.keys() == come.keys()
    sent, told = b"".join(spoken.values()), b"".join(come.values())
    wrong = sum(a != b for a, b in zip(sent, told, strict=True))
    assert wrong / len(sent) == pytest.approx(0.05, rel=0.15)


def test_a_late_radio_is_late_both_ways_and_byte_for_byte() -> None:
    sea = Troubled()
    sea.fail(1, "radio_late", value=0.5)
    records = sea.sail(150)
    spoken, come = dict(said(records, 1)), dict(heard(records, 2, RADIO))
    assert come == {t + 500_000: data for t, data in spoken.items() if t + 500_000 < sea.t_us}
    in_time = [(t + 500_000, data) for t, data in said(records, 0) if t + 500_000 < sea.t_us]
    assert len(in_time) > 5 and set(in_time) <= set(heard(records, 1, RADIO))
    sea.heal(1, "radio_late")
    sea.tick(60)
    records = sea.sail(100)
    assert dict(said(records, 1)) == dict(heard(records, 2, RADIO))


def test_an_impostor_sends_another_position_with_the_same_id() -> None:
    sea = Troubled()
    sea.fail(0, "impostor", value=25.0)
    told = [m for m in positions(sea.sail(2), 1, RADIO) if m.get_srcSystem() == 100]
    true, false, *_ = told
    assert false.x == pytest.approx(true.x + 25.0, abs=0.01) and false.y == true.y
    assert false.time_boot_ms > true.time_boot_ms
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in told} == {(100, 1)}


def test_a_replay_repeats_earlier_messages_byte_for_byte() -> None:
    sea = Troubled()
    sea.fail(1, "replay", value=0.5)
    records = sea.sail(120)
    spoken, come = dict(said(records, 1)), dict(heard(records, 2, RADIO))
    echoes = {t + 500_000: data for t, data in spoken.items() if t + 500_000 < sea.t_us}
    assert len(echoes) > 5
    assert come == {t: spoken.get(t, b"") + echoes.get(t, b"") for t in {*spoken, *echoes}}


def test_a_vessel_at_anchor_tells_its_position_and_has_two_heartbeats() -> None:
    sea = Troubled()
    x, y, psi = sea.eta[1]
    sea.fail(1, "anchored", value=6.0)
    wire = heard(sea.sail(200), 1, RADIO)
    told = positions_of(wire, 110)
    assert len(told) == 10 and all(math.isnan(m.vx) for m in told)
    ((north, east),) = {(m.x, m.y) for m in told}
    assert north == pytest.approx(x + 6.0 * math.cos(psi), abs=1e-4)
    assert east == pytest.approx(y + 6.0 * math.sin(psi), abs=1e-4)
    beats = [m for m in messages(wire, "HEARTBEAT") if m.get_srcSystem() == 110]
    assert {(m.type, m.autopilot, m.get_srcComponent()) for m in beats} == {(11, 0, 1), (11, 0, 2)}
    sea.heal(1, "anchored")
    assert positions_of(heard(sea.sail(100), 1, RADIO), 110) == []


def test_a_vessel_at_anchor_is_heard_promptly_at_first_and_always_late() -> None:
    sea = Troubled()
    sea.fail(1, "anchored_late", value=1.0)
    ages = []
    for t_us, data in heard(sea.sail(250), 1, RADIO):
        ages += [t_us - 1000 * m.time_boot_ms for m in positions_of([(t_us, data)], 110)]
    assert set(ages) == {0, 1_000_000}
    assert ages[:5] == [0] * 5 and ages[-5:] == [1_000_000] * 5


def test_a_crowd_is_anchored_every_five_metres_and_the_nearest_is_heard_last() -> None:
    sea = Troubled()
    x, y, _ = sea.eta[1]
    sea.fail(1, "crowd", value=40.0)
    wire = heard(sea.sail(1), 1, RADIO)
    crowd = [m for m in messages(wire, "LOCAL_POSITION_NED") if m.get_srcSystem() >= 110]
    away = [math.hypot(m.x - x, m.y - y) for m in crowd]
    assert away == pytest.approx([6.0 + 5.0 * n for n in reversed(range(40))], abs=0.05)


def test_an_ais_receiver_reports_a_ship_at_anchor_once_in_three_minutes() -> None:
    sea = Troubled()
    x, y, psi = sea.eta[1]
    sea.fail(1, "ais_ship", value=6.0)
    (ship,) = messages(heard(sea.sail(300), 1, RADIO), "AIS_VESSEL")
    assert (ship.MMSI, ship.navigational_status) == (227_000_000, 1)
    north = 1e-7 * (ship.lat - 487_000_000) * math.pi / 180 * 6_371_000
    parallel = math.cos(math.radians(48.7))
    east = 1e-7 * (ship.lon - 22_950_000) * math.pi / 180 * 6_371_000 * parallel
    assert north == pytest.approx(x + 6.0 * math.cos(psi), abs=0.05)
    assert east == pytest.approx(y + 6.0 * math.sin(psi), abs=0.05)


def test_a_station_overrides_with_everything_at_rest() -> None:
    sea = Troubled()
    sea.fail(1, "overrides")
    told = messages(heard(sea.sail(100), 1, RADIO), "RC_CHANNELS_OVERRIDE")
    assert {(m.target_system, m.chan1_raw, m.chan3_raw, m.chan7_raw) for m in told} == {
        (1, 1500, 1500, 1100)
    }
    assert len(told) == 20 and told[0].get_srcSystem() == 255
    sea.fail(1, "radio_silent")
    assert not messages(heard(sea.sail(100), 1, RADIO), "RC_CHANNELS_OVERRIDE")


# -- the boat


@pytest.mark.parametrize("by_s", [HOUR_S, -HOUR_S])
def test_a_vessels_clock_jumps_and_jumps_back(by_s: float) -> None:
    sea = Troubled(LONG_AGO)
    (before, *_) = positions(sea.sail(1), 1)
    sea.fail(1, "clock", value=by_s)
    (after, *_) = positions(sea.sail(1), 1)
    assert after.time_boot_ms - before.time_boot_ms == 1000 * by_s + 10
    sea.heal(1, "clock")
    (later, *_) = positions(sea.sail(1), 1)
    assert later.time_boot_ms - before.time_boot_ms == 20


def test_a_restarting_boat_is_silent_and_keeps_its_parameters() -> None:
    sea = Troubled()
    before = sea.fleet.parameters(1)
    sea.fail(1, "restart")
    records = sea.sail(30)
    assert said(records, 1) == said(records, 1, NAVIGATION) == []
    assert heard(records, 1, RADIO) == frames(records, 1, to_boat=True) == []
    assert frames(records, 1, to_boat=False) == []
    assert not sea.commands[0].any()  # its ESCs stop by themselves
    sea.heal(1, "restart")
    sea.tick(100)
    assert sea.state(1) == "DISARMED" and sea.conditions(1)["own_fresh"]
    assert sea.fleet.parameters(1) == before
    sea.enter_formation([1])
    assert sea.state(1) == "FORMATION"


# -- all of them


@pytest.mark.parametrize("kind", [one.name for one in KINDS.values() if one.owner != "world"])
def test_a_fault_leaves_no_trace_and_depends_only_on_its_seed(kind: str) -> None:
    def sail(seed: int, fails: bool) -> tuple[bytes, bytes]:
        sea = Troubled(LONG_AGO)
        for agent in (1, 2) if fails else ():
            sea.fail(agent, kind, value=0.2, seed=seed)
        sea.tick(40)
        meanwhile = sea.fleet.take_records(0)
        sea.heal(1, kind)
        sea.heal(2, kind)
        sea.heal(2, kind)  # nothing happens
        for _ in range(2):  # damaged bytes may hide one command, as if it were part of a message
            sea.fleet.command([1, 2], sea.t_us, 400, (0.0,))
            sea.tick(150)
        assert {sea.state(1), sea.state(2)} == {"DISARMED"}
        met = [name for name, well in sea.conditions(1).items() if well]
        assert {"own_fresh", "leader_fresh", "escs_online", "bus_up"} <= set(met)
        return meanwhile, sea.fleet.take_records(0)

    assert sail(3, fails=True) == sail(3, fails=True)
    assert sail(3, fails=True)[0] != sail(3, fails=False)[0]
    if kind in ("frame_loss", "radio_loss", "byte_errors"):
        assert sail(3, fails=True) != sail(4, fails=True)


@pytest.mark.parametrize(
    ("agent", "kind", "named", "words"),
    [
        (1, "own_sick", {}, "kind: none of flotilla.fault_list()"),
        (1, "gcs_silent", {}, "not on a fleet's wires"),
        (0, "pilot", {"value": 0.5}, "agent 0 is a leader, not a boat"),
        (1, "pilot", {"value": 1.1}, "pilot: value: a number from -1 to 1"),
        (1, "radio_late", {"value": -1.0}, "a number from 0 to 1e+06"),
        (9, "own_silent", {}, "agent 9: there are 3"),
        (0, "esc_stuck", {}, "agent 0 is a leader, not a boat"),
        (0, "restart", {}, "agent 0 is a leader, not a boat"),
        (1, "own_jump", {"esc": "port"}, "only a fault of ESCs"),
        (1, "esc_stuck", {"esc": "left"}, '"port", "stbd" or None'),
        (1, "frame_loss", {"value": 1.1}, "a number from 0 to 1"),
        (1, "own_jump", {"value": math.nan}, "a number from -1e+06 to 1e+06"),
        (1, "replay", {"value": -1.0}, "a number from 0 to 1e+06"),
        (1, "clock", {"value": -HOUR_S}, "before 0"),
        (0, "own_clock", {"value": -HOUR_S}, "before 0"),
    ],
)
def test_an_impossible_fault_is_refused_with_the_reason(
    agent: int, kind: str, named: dict[str, Any], words: str
) -> None:
    sea = Troubled()
    with pytest.raises(ValueError, match="(?s).*" + re.escape(words)):
        sea.fail(agent, kind, **named)
    well = Troubled()
    assert sea.sail(20) == well.sail(20)


def test_a_second_jump_of_the_clock_takes_the_place_of_the_first() -> None:
    sea = Troubled(LONG_AGO)
    (before, *_) = positions(sea.sail(1), 1)
    sea.fail(1, "clock", value=50.0)
    sea.fail(1, "clock", value=20.0)
    (after, *_) = positions(sea.sail(1), 1)
    assert after.time_boot_ms - before.time_boot_ms == 20_000 + H_US // 1000
