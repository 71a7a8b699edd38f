# SPDX-License-Identifier: MIT
"""A view's vessels from received messages."""

import random
from math import pi
from typing import Any

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.plant.hull import Array
from sil.scenario.wiring import ORIGIN, VIRTUAL_LEADER_SYSTEM, WORLD
from sil.view.seen_fleet import FORGOTTEN_S
from tests.dialect import dialect
from tests.sil.fleet.waters import beacon_message
from tests.sil.view.feed import (
    BEAT,
    VIRTUAL,
    Listening,
    Told,
    attitude,
    local,
    origin,
    said,
    sail_and_look,
    slot,
    value,
)
from tests.target.stations import heartbeat
from tests.turns import some

CONDITIONS = len(flotilla.supervisor_conditions())
ALL, ALL2 = float((1 << 24) - 1), float((1 << CONDITIONS - 24) - 1)


def test_real_boats_are_where_they_are_and_their_slots_go_with_their_leaders() -> None:
    view, compared = Listening(), 0

    def look(k: int, chunks: list[bytes], eta: Array) -> None:
        nonlocal compared
        for chunk in chunks:
            view.hear(chunk, 0.01 * k)
        if k < 200 or k % 10 != 7:
            return
        vessels = view.by_id(0.01 * k)
        assert list(vessels) == [1, 2, 3, 4, VIRTUAL_LEADER_SYSTEM]
        for vessel, truth in zip(vessels.values(), [*eta[1:], eta[0]], strict=True):
            assert (vessel["x_m"], vessel["y_m"]) == pytest.approx(truth[:2], abs=0.001)
            assert (vessel["psi_rad"] - truth[2] + pi) % (2 * pi) - pi == pytest.approx(0, abs=1e-3)
            if vessel["kind"] == "boat":
                assert vessel["state"] == "FORMATION" and vessel["held"] == ()
                assert vessel["battery_V"] == 24.0 and len(vessel["escs"]) == 2
                compared += 1
        assert vessels[VIRTUAL_LEADER_SYSTEM]["kind"] == "leader"

    sail_and_look(look, "duration_s=12")
    assert compared > 300
    assert view.ear.damaged == 0


def test_a_boats_reported_error_is_its_distance_from_its_slot_on_the_page() -> None:
    view, told = Listening(), list[Told]()

    def look(k: int, chunks: list[bytes], _: Array) -> None:
        for chunk in chunks:
            view.hear(chunk, 0.01 * k)
        if k > 100 and k % 50 == 0:
            told.append(view.fleet.vessels(0.01 * k))

    sail_and_look(look, "duration_s=8", "parameters.SR_SLOW=50")
    for vessel in some(v for vessels in told for v in vessels if v["kind"] == "boat"):
        north, east = vessel["slot"]
        apart_m = ((vessel["x_m"] - north) ** 2 + (vessel["y_m"] - east) ** 2) ** 0.5
        assert vessel["error_m"] == pytest.approx(apart_m, abs=0.02)


def test_real_boats_whose_leader_is_lost_coast_and_hold_and_say_why() -> None:
    view, seen = Listening(), list[tuple[str, tuple[str, ...]]]()

    def look(k: int, chunks: list[bytes], _: Array) -> None:
        for chunk in chunks:
            view.hear(chunk, 0.01 * k)
        if k > 150:
            boat = view.by_id(0.01 * k)[1]
            assert boat["leader"] == VIRTUAL_LEADER_SYSTEM and boat["limits_N"] == (-50.0, 50.0)
            assert max(map(abs, boat["thrust_N"])) <= 50.0
            if not seen or seen[-1] != (boat["state"], boat["held"]):
                seen.append((boat["state"], boat["held"]))

    sail_and_look(look, "duration_s=14", "fault=[{kind='radio_silent', agent=0, at_s=3.0}]")
    states = [state for state, _ in seen]
    assert sorted(set(states), key=states.index) == ["FORMATION", "COAST", "HOLD"]
    assert seen[0] == ("FORMATION", ()) and states[-1] == "HOLD"
    assert seen[-1][1] == ("leader lost or origin unknown",)


def boat(system: int, x: float = 0.0) -> bytes:
    return said(system, BEAT, origin(*ORIGIN), attitude(0.5), local(x, 2.0, 1.0, 0.0))


def test_all_values_that_a_boat_sends_are_on_the_page() -> None:
    view = Listening()
    values = {"E_X": 3.0, "E_Y": -4.0, "LEADER": 9.0, "LEAD_AGE": 0.25, "COND": ALL, "COND2": ALL2}
    values |= {"T_PORT": 5.0, "T_STBD": -2.0, "T_MAX": 20.0, "T_MIN": -15.0}
    escs = [
        dialect().MAVLink_esc_status_message(0, 0, [100, -50, 0, 0], [24.5] * 4, [1.25] * 4),
        dialect().MAVLink_esc_info_message(
            0, 0, 0, 2, 5, 3, [0] * 4, [7, 0, 0, 0], [3150, 32767, 0, 0]
        ),
    ]
    text = mavlink.MAVLink_statustext_message(4, b"FORMATION")
    battery = mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 23900, -1, -1, 0, 0, 0, 0, 0, 0)
    view.hear(boat(2, 7.0) + said(2, slot(1.0, 2.0), text, battery, *escs), 5.0)
    view.hear(said(2, *(value(name, number) for name, number in values.items())), 5.0)
    (vessel,) = view.fleet.vessels(5.5)
    assert vessel == {
        "id": 2,
        "kind": "boat",
        "senders": None,
        "x_m": 7.0,
        "y_m": 2.0,
        "place_age_s": 0.5,
        "psi_rad": 0.5,
        "u_mps": 0.878,
        "v_mps": -0.479,
        "length_m": 1.0,
        "leader": 9,
        "slot": (1.0, 2.0),
        "error_m": 5.0,
        "in_slot": None,
        "thrust_N": (5.0, -2.0),
        "limits_N": (-15.0, 20.0),
        "item": None,
        "state": "FORMATION",
        "unknown_mode": None,
        "held": (),
        "conditions_lost_s": None,
        "text": "FORMATION",
        "text_age_s": 0.5,
        "link_age_s": 0.5,
        "leader_age_s": 0.25,
        "battery_V": 23.9,
        "escs": [
            {"rpm": 100, "voltage_V": 24.5, "current_A": 1.25, "temperature_C": 31.5, "errors": 7},
            {"rpm": -50, "voltage_V": 24.5, "current_A": 1.25, "temperature_C": None, "errors": 0},
        ],
    }


def test_zeros_of_an_esc_that_is_not_online_are_no_measurements() -> None:
    def told(online: int) -> bytes:
        status = dialect().MAVLink_esc_status_message(0, 0, [100, 0, 0, 0], [24.5] * 4, [1.0] * 4)
        info = dialect().MAVLink_esc_info_message(0, 0, 0, 2, 5, online, [0] * 4, [0] * 4, [0] * 4)
        return said(2, status, info)

    view = Listening()
    for online in (1, 3):
        view.hear(boat(2) + told(online), 0.0)
        port, stbd = view.by_id(0.5)[2]["escs"]
        assert port["rpm"] == 100
        assert (set(stbd.values()) == {None}) == (online == 1)


def test_a_value_that_a_boat_no_longer_sends_is_not_known() -> None:
    view = Listening()
    for t_s in (0.0, 1.0):
        view.hear(boat(2) + said(2, slot(1.0, 2.0), value("E_X", 1.0), value("E_Y", 0.0)), t_s)
    view.hear(boat(2), 8.0)
    vessel = view.by_id(8.0)[2]
    assert vessel["error_m"] is None and vessel["slot"] is None and vessel["x_m"] == 0.0


def test_slow_telemetry_is_known_between_its_messages_and_its_end_is_a_trouble() -> None:
    view = Listening()
    holds = mavlink.MAVLink_heartbeat_message(11, 0, 137, 4, 4, 3)
    battery = mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 23900, -1, -1, 0, 0, 0, 0, 0, 0)
    slow = [value("COND", 0.0), value("COND2", 0.0), value("IN_SLOT", 1.0), battery, slot(1.0, 2.0)]
    for t_s in range(120):
        view.hear(boat(2) + said(2, holds), t_s)
        if t_s % 10 == 0 and t_s <= 60:
            view.hear(said(2, *slow), t_s)
            view.hear(said(2, *slow), t_s + 0.1)  # the same over another link
        vessel = view.by_id(t_s + 0.2)[2]
        assert vessel["state"] == "HOLD"
        known = [vessel[name] for name in ("held", "in_slot", "battery_V", "slot")]
        if t_s <= 80:
            assert all(known) and vessel["conditions_lost_s"] is None
        elif t_s >= 90:
            assert not any(known) and vessel["conditions_lost_s"] == t_s - 60


def test_an_unknown_mode_is_reported_while_its_heartbeat_is_heard() -> None:
    view = Listening()
    odd = mavlink.MAVLink_heartbeat_message(11, mavlink.MAV_AUTOPILOT_GENERIC, 137, 77, 4, 3)
    view.hear(said(1, odd) + boat(2), 0.0)
    told = view.by_id(1.0)
    assert [(v["state"], v["unknown_mode"]) for v in told.values()] == [
        (None, 77),
        ("FORMATION", None),
    ]
    view.hear(said(1, attitude(0.0)), 9.0)
    assert view.by_id(9.0)[1]["unknown_mode"] is None


def test_a_silent_boat_stays_with_its_age_and_last_values_and_others_are_dropped() -> None:
    view = Listening()
    view.hear(boat(2, 7.0) + said(2, value("E_X", 3.0), value("E_Y", 4.0)), 0.0)
    view.hear(said(100, VIRTUAL, local(1.0, 1.0)), 0.0)
    assert list(view.by_id(FORGOTTEN_S)) == [2, 100]
    (vessel,) = view.fleet.vessels(3600.0)
    assert (vessel["link_age_s"], vessel["error_m"], vessel["state"]) == (3600.0, 5.0, "FORMATION")
    assert (vessel["x_m"], vessel["place_age_s"]) == (7.0, 3600.0)


def test_the_reason_that_holds_a_boat_is_shown_in_its_words() -> None:
    bits = {c["name"]: 1 << c["bit"] for c in flotilla.supervisor_conditions()}
    lost = ALL - bits["leader_fresh"]
    coasting = mavlink.MAVLink_heartbeat_message(11, 0, 137, 6, 5, 3)
    view = Listening()
    view.hear(boat(3) + said(3, coasting, value("COND", lost), value("COND2", ALL2)), 0.0)
    vessel = view.by_id(0.0)[3]
    assert (vessel["state"], vessel["held"]) == ("COAST", ("leader lost or origin unknown",))


def test_every_text_has_its_time_and_severity_and_a_repeated_one_comes_once() -> None:
    view = Listening()
    texts = [(2, b"first"), (6, b"second"), (6, b"second")]
    packed = [mavlink.MAVLink_statustext_message(severity, text) for severity, text in texts]
    view.hear(boat(1) + said(255, packed[0], component=190) + said(1, *packed), 3.0)
    view.hear(said(1, packed[0]), 4.0)
    assert view.fleet.texts() == [
        (2, 3.0, 1, 2, "first"),
        (3, 3.0, 1, 6, "second"),
        (4, 4.0, 1, 2, "first"),
    ]
    for number in range(100):
        view.hear(said(1, mavlink.MAVLink_statustext_message(6, b"%d" % number)), 5.0)
    assert len(view.fleet.texts()) == 50 and view.fleet.texts()[-1][-1] == "99"


def test_a_long_text_is_shown_whole_and_one_that_lost_a_piece_is_not_shown() -> None:
    words = b"a sentence that is longer than fifty characters and goes on in a second piece"
    pieces = [words[:50], words[50:]]
    view = Listening()
    chunks = [mavlink.MAVLink_statustext_message(4, p, 8, i) for i, p in enumerate(pieces)]
    view.hear(boat(1) + said(1, *chunks), 0.0)
    assert view.by_id(0.0)[1]["text"] == words.decode()
    view.hear(said(1, mavlink.MAVLink_statustext_message(4, b"its end only", 9, 1)), 1.0)
    assert view.by_id(1.0)[1]["text"] == words.decode()


def test_vessels_of_other_kinds_are_distinguished_and_stations_are_ignored() -> None:
    view = Listening()
    rover = mavlink.MAVLink_heartbeat_message(11, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 129, 4, 4, 3)
    view.hear(boat(1) + said(100, VIRTUAL) + said(7, rover) + said(255, heartbeat(6)), 0.0)
    view.hear(said(255, *[mavlink.MAVLink_timesync_message(0, 1)] * 5, component=190), 0.0)
    vessels = view.by_id(0.0)
    assert {k: v["kind"] for k, v in vessels.items()} == {1: "boat", 7: "vessel", 100: "leader"}
    assert vessels[7]["state"] is None
    assert view.fleet.ignored == 6


def test_a_boat_with_ardupilots_identity_is_recognised_by_its_conditions() -> None:
    view = Listening()
    rover = mavlink.MAVLink_heartbeat_message(11, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 129, 4, 4, 3)
    view.hear(said(7, rover, value("COND", ALL), rover), 0.0)
    vessel = view.by_id(0.0)[7]
    assert (vessel["kind"], vessel["state"]) == ("boat", "HOLD")


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        (said(7, value("COND", ALL)), "boat"),
        (said(7, value("SEP_M", 3.0)), "boat"),
        (beacon_message(7, 1, 5), "boat"),
        (said(7, value("DEPTH", 1.0)), "vessel"),  # another firmware's echo sounder
        (said(7, value("COND", ALL), component=220), "vessel"),
    ],
    ids=["COND", "SEP_M", "beacon", "DEPTH", "another component"],
)
def test_a_vessel_that_once_sent_a_flotilla_message_stays_a_flotilla_boat(
    words: bytes, kind: str
) -> None:
    view = Listening()
    rover = mavlink.MAVLink_heartbeat_message(11, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 129, 4, 4, 3)
    view.hear(words, 0.0)
    for t_s in range(1, 30):
        view.hear(said(7, rover), float(t_s))
        assert view.by_id(float(t_s))[7]["kind"] == kind


def test_a_boats_navigation_unit_with_its_system_id_is_not_the_boat() -> None:
    view = Listening()
    view.hear(said(1, VIRTUAL, local(50.0, 50.0), component=220), 0.0)
    assert view.fleet.vessels(0.0) == []
    view.hear(boat(1, 3.0), 0.1)
    view.hear(said(1, VIRTUAL, local(50.0, 50.0), attitude(2.0), component=220), 0.2)
    vessel = view.by_id(0.2)[1]
    assert (vessel["kind"], vessel["x_m"], vessel["psi_rad"]) == ("boat", 3.0, 0.5)


def test_beside_another_autopilot_the_state_is_the_companions() -> None:
    view = Listening()
    rover = mavlink.MAVLink_heartbeat_message(
        11, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 129, 15, 4, 3
    )
    companion = mavlink.MAVLink_heartbeat_message(18, mavlink.MAV_AUTOPILOT_INVALID, 129, 4, 4, 3)
    view.hear(said(4, rover, origin(*ORIGIN), local(1.0, 2.0), attitude(0.0)), 0.0)
    view.hear(said(4, value("COND", ALL), companion, component=191), 0.1)
    view.hear(said(4, rover), 0.2)
    vessel = view.by_id(0.2)[4]
    assert (vessel["kind"], vessel["state"], vessel["x_m"]) == ("boat", "HOLD", 1.0)


@pytest.mark.parametrize("message", ["odometry", "global", "follow_target"])
def test_a_leaders_position_is_right_with_every_kind_of_message(message: str) -> None:
    view, worst = Listening(), [0.0]

    def look(k: int, chunks: list[bytes], eta: Array) -> None:
        for chunk in chunks:
            view.hear(chunk, 0.01 * k)
        if k > 200 and k % 20 == 0:
            leader = view.by_id(0.01 * k)[VIRTUAL_LEADER_SYSTEM]
            worst.append(abs(leader["x_m"] - eta[0, 0]) + abs(leader["y_m"] - eta[0, 1]))
            assert leader["psi_rad"] == pytest.approx(eta[0, 2], abs=0.01)
            assert leader["u_mps"] > 0.3

    sail_and_look(look, "duration_s=6", f"leader.navigation.message='{message}'")
    assert len(worst) > 10 and max(worst) < 0.1


def test_boats_of_other_origins_are_in_one_frame() -> None:
    there = WORLD.moved(900.0, -400.0)
    view = Listening()
    view.hear(boat(1, 5.0), 0.0)
    view.hear(said(2, BEAT, origin(*there.origin_degE7, ORIGIN[2]), attitude(0.0)), 0.0)
    view.hear(said(2, local(-100.0, 0.0)), 0.0)
    vessel = view.by_id(0.0)[2]
    assert (vessel["x_m"], vessel["y_m"]) == pytest.approx((800.0, -400.0), abs=0.05)


def test_without_an_origin_the_first_global_position_becomes_the_origin() -> None:
    view = Listening()
    here = mavlink.MAVLink_global_position_int_message(0, *ORIGIN, 0, 100, 0, 0, 65535)
    there = mavlink.MAVLink_global_position_int_message(
        0, ORIGIN[0] + 900, ORIGIN[1], 0, 0, 100, 0, 0, 65535
    )
    for t_s in (0.0, 3.0):
        view.hear(said(1, BEAT, attitude(0.0), here) + said(2, BEAT, there), t_s)
    vessels = view.by_id(3.0)
    assert (vessels[1]["x_m"], vessels[1]["u_mps"]) == (0.0, 1.0)
    assert vessels[2]["x_m"] == pytest.approx(10.0, abs=0.05)


def test_a_restarted_boat_keeps_no_values_from_before() -> None:
    view = Listening()
    before = said(1, BEAT, origin(*ORIGIN), attitude(0.5, 90_000), local(1.0, 1.0), slot(5.0, 5.0))
    view.hear(before + said(1, value("E_X", 3.0), value("E_Y", 4.0)), 0.0)
    for step in range(12):
        told = origin(1, 2) if step == 0 else local(9.0, 9.0) if step == 1 else value("T_MAX", 1.0)
        view.hear(said(1, attitude(0.1, 50 + 100 * step), told), 0.5 + 0.1 * step)
    vessel = view.by_id(1.6)[1]
    assert (vessel["error_m"], vessel["slot"], vessel["psi_rad"]) == (None, None, 0.1)
    assert view.fleet.systems[1].motion.origin == (1, 2, 0)
    assert view.fleet.systems[1].motion.place is not None


def test_a_late_message_takes_no_boat_off_the_map_and_clears_no_trouble() -> None:
    view = Listening()
    holds = mavlink.MAVLink_heartbeat_message(11, 0, 137, 4, 4, 3)
    view.hear(said(1, holds, origin(*ORIGIN), local(7.0, 2.0)), 0.0)
    view.hear(said(1, value("COND", 0.0), value("COND2", 0.0)), 0.0)
    for step in range(50):
        late_s = 4.0 if step % 20 < 3 else 0.0  # three that a radio has held back
        view.hear(said(1, attitude(0.5, 90_000 + 100 * step - int(1000 * late_s))), 0.1 * step)
        vessel = view.by_id(0.1 * step)[1]
        assert vessel["x_m"] == 7.0 and vessel["held"] and vessel["senders"] is None


def test_two_boats_with_one_id_are_reported_and_stay_on_the_map() -> None:
    view = Listening()
    view.hear(said(1, BEAT, origin(*ORIGIN), local(7.0, 2.0)), 0.0)
    for step in range(320):
        both = step < 200
        boot_ms = 100 * step + 90_000 * (both and step % 2)
        view.hear(said(1, attitude(0.5, boot_ms)), 0.1 * step)
        vessel = view.by_id(0.1 * step)[1]
        assert vessel["x_m"] == 7.0 and (vessel["senders"] == 2 or not both or step < 10)
    assert vessel["senders"] is None


@pytest.mark.parametrize("after_s", [3.0, 10.0, 120.0])
def test_a_fleet_that_comes_back_elsewhere_with_its_clocks_at_0_is_shown_there(
    after_s: float,
) -> None:
    view = Listening()
    for system in (1, 2, 3):
        view.hear(said(system, BEAT, origin(*ORIGIN), attitude(0.0, 99_000), local(1.0, 1.0)), 0.0)
    assert len(view.fleet.vessels(0.1)) == 3
    for step in range(80):
        t_s = after_s + 0.1 * step
        for system in (1, 2):
            at = origin(-337_000_000, 1_510_000_000)
            view.hear(
                said(system, BEAT, at, attitude(0.0, 100 * step), local(7.0 * system, 0.0)), t_s
            )
    vessels = view.by_id(t_s)
    assert list(vessels) == [1, 2]
    assert [vessels[k]["x_m"] for k in (1, 2)] == [7.0, 14.0]


def test_impossible_numbers_count_as_unknown() -> None:
    nan, inf = float("nan"), float("inf")
    view = Listening()
    view.hear(said(1, BEAT, origin(*ORIGIN), attitude(nan), local(nan, inf)), 0.0)
    view.hear(said(1, value("E_X", nan), value("E_Y", 1.0), value("LEADER", inf)), 0.0)
    view.hear(said(1, value("COND", -1.0), value("T_PORT", inf), slot(nan, 0.0)), 0.0)
    vessel = view.by_id(0.0)[1]
    unknown = ("x_m", "psi_rad", "u_mps", "error_m", "leader", "slot", "thrust_N")
    assert [vessel[name] for name in unknown] == [None] * 7 and vessel["held"] == ()


def test_boats_of_every_system_id_are_shown_and_random_messages_break_nothing() -> None:
    rng, view = random.Random(3), Listening()
    kinds = [dialect().mavlink_map[number] for number in dialect().mavlink_map]
    for step in range(3000):
        kind, encoder = rng.choice(kinds), dialect().MAVLink(None, rng.randrange(1, 255), 1)
        payload = rng.randbytes(kind.unpacker.size)
        message: Any = kind.__new__(kind)
        dialect().MAVLink_message.__init__(message, kind.id, kind.msgname)
        view.hear(bytes(message._pack(encoder, kind.crc_extra, payload)), 0.01 * step)
        if step % 100 == 0:
            view.fleet.vessels(0.01 * step)
    for system in range(1, 256):
        view.hear(boat(system, float(system)), 40.0)
    vessels = view.by_id(40.0)
    assert len(vessels) == 255


def test_an_impossibly_distant_position_is_ignored() -> None:
    view = Listening()
    view.hear(boat(1, 3.0) + boat(2, 3e38), 0.0)
    assert [view.by_id(0.0)[i]["x_m"] for i in (1, 2)] == [3.0, None]


def test_a_boat_without_new_positions_keeps_its_last_one_with_its_age() -> None:
    view = Listening()
    view.hear(boat(2, 7.0), 0.0)
    for t_s in range(1, 9):
        view.hear(said(2, BEAT), float(t_s))
    vessel = view.by_id(8.0)[2]
    assert (vessel["link_age_s"], vessel["x_m"], vessel["place_age_s"]) == (0.0, 7.0, 8.0)
    assert vessel["psi_rad"] is None and vessel["u_mps"] is None
