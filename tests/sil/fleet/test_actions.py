# SPDX-License-Identifier: MIT
"""`flotilla fleet` against the firmware: what an operator says, and what the boats then do."""

import io
import math
import re
from collections.abc import Sequence
from itertools import combinations, permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console

from sil.fleet.actions import Wish, perform
from sil.fleet.ends import End, Peer
from sil.fleet.orders import carry_out, long, stop
from sil.fleet.station import COMPONENT, Ack, Station
from sil.fleet.tables import assigned, shape_places
from sil.scenario.formation import Formation, slots
from sil.wire import signing
from sil.wire.fleet_table import Beacon, beacon_of
from sil.wire.heartbeat import HOLD, MANUAL
from sil.wire.mavlink_ear import Ear
from sil.wire.mavlink_frames import frames
from sil.wire.mavlink_messages import FLEET_TABLE
from sil.wire.operator import Operator, mode_request
from sil.wire.signing import Signer
from tests.each_push import few
from tests.sil.fleet.waters import BOATS, Air, Waters, heard

KEY = bytes(range(32))


@pytest.fixture
def waters() -> Waters:
    return Waters()


def sail(waters: Waters, for_s: float) -> None:
    waters.wait((), for_s)


def form(waters: Waters, shape: str, spacing_m: float | None = None) -> None:
    """Form the boats; asserts that none stops."""
    wish: dict[str, Any] = {
        "shape": shape,
        "spacing_m": spacing_m,
        "boats": BOATS,
        "turning": False,
    }
    status, words = waters.command(action="form", **wish)
    assert "is in force with 4 of 4 boats" in words
    assert status == 0 and "HOLD" not in waters.states


def off_m(waters: Waters, shape: str, spacing_m: float) -> float:
    """How far the worst boat is from the shape's places, relative to the boat in the first one.

    Any boat may have any place, the leader too.
    """
    (x, y), *others = slots(Formation(shape=shape, boats=len(BOATS), spacing_m=spacing_m))  # type: ignore[arg-type]
    wanted = np.array([(0.0, 0.0), *((a - x, b - y) for a, b in others)])
    found = waters.places()
    orders = [list(order) for order in permutations(range(len(BOATS)))]
    shapes = [found[order] - found[order[0]] for order in orders]
    return min(float(np.hypot(*(shape - wanted).T).max()) for shape in shapes)


def test_the_first_line_of_status_counts_the_boats_in_formation(waters: Waters) -> None:
    status, words = waters.command(action="status")
    first, _, *rows = words.splitlines()
    assert (status, first) == (0, "4 of 4 in formation behind boat 1")
    assert [row.split()[:2] for row in rows] == [
        ["1", "AUTO"],
        *([str(boat), "FORMATION"] for boat in (2, 3, 4)),
    ]
    assert all("24.0 V" in row for row in rows)


def test_a_silent_boat_is_named_and_its_values_are_unknown(waters: Waters) -> None:
    assert waters.command(action="form", shape="vee", spacing_m=4.5)[0] == 0
    waters.fault(3, "restart")
    waters.deaf.add(3)
    status, words = waters.command(action="status", boats=BOATS)
    assert status == 1
    assert words.splitlines()[0] == "3 of 4 in formation behind boat 1; boat 3 silent"
    row = next(row for row in words.splitlines() if row.startswith("3   "))
    assert row.split() == ["3", *"––––––", "never"]


def test_a_shape_is_taken_under_way(waters: Waters) -> None:
    form(waters, "diamond", 4.5)
    sail(waters, 40.0)
    assert off_m(waters, "diamond", 4.5) < 0.5
    form(waters, "line", 5.0)
    sail(waters, 40.0)
    assert off_m(waters, "line", 5.0) < 0.5
    assert waters.states == ["AUTO", *["FORMATION"] * 3]


@pytest.mark.parametrize("seed", few(range(8), [2, 7]))
def test_boats_exchange_their_places_without_a_stop(seed: int) -> None:
    """Directly at first, as no table is there yet; then together."""
    waters = Waters(loss=0.1, seed=seed + 1, boat_loss=0.2)
    nearest_m = math.inf
    for shape in ("diamond", "vee", "column"):
        form(waters, shape, 4.5)
        for _ in range(50):
            sail(waters, 1.0)
            pairs = combinations(waters.places(), 2)
            nearest_m = min(nearest_m, *(math.dist(*pair) for pair in pairs))
        assert waters.states == ["AUTO", *["FORMATION"] * 3]
        assert off_m(waters, shape, 4.5) < 0.5
    assert nearest_m > 1.44  # the guard


def test_the_places_of_a_file_form_a_shape(waters: Waters, tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text("places_m = [[0, 0], [-6, 1.5], [-3, -4], [-3, 5]]\n")
    form(waters, str(file))
    sail(waters, 40.0)
    for wanted in ((0, 0), (-6, 1.5), (-3, -4), (-3, 5)):
        assert min(math.dist(wanted, place) for place in waters.places()) < 0.5


def test_the_first_boat_named_leads(waters: Waters) -> None:
    order = (2, 1, 3, 4)
    waters.command(action="hold")
    assert waters.command(action="form", shape="column", spacing_m=4.5, boats=order)[0] == 0
    status, words = waters.command(action="loiter")
    assert status == 0 and "boat 2 leads" in words
    assert waters.state(2) == "LOITER"
    assert waters.command(action="follow")[0] == 0
    assert waters.states == ["FORMATION", "LOITER", "FORMATION", "FORMATION"]


def test_an_order_to_the_leader_moves_the_fleet(waters: Waters) -> None:
    assert waters.command(action="form", shape="vee", spacing_m=4.5)[0] == 0
    assert waters.command(action="loiter")[0] == 0
    assert waters.states == ["LOITER", *["FORMATION"] * 3]
    eta = waters.batch.bodies.eta[waters.agent(1), :2].copy()
    status, words = waters.command(action="go", way_m=(12.0, -5.0))
    assert status == 0 and "the others follow it and received no command" in words
    assert waters.state(1) == "GUIDED"
    sail(waters, 60.0)
    moved = waters.batch.bodies.eta[waters.agent(1), :2] - eta
    assert math.dist(moved, (12.0, -5.0)) < 3.0  # it drifted while it was asked
    assert waters.command(action="auto")[0] == 0
    assert waters.command(action="return")[0] == 0
    assert waters.state(1) == "RTL"


def test_go_waits_until_the_named_boats_position_is_heard(waters: Waters) -> None:
    status, words = waters.command(action="go", way_m=(12.0, -5.0), boats=(1,))
    assert status == 0, words
    assert waters.state(1) == "GUIDED"


def test_hold_and_follow_again(waters: Waters) -> None:
    waters.command(action="form", shape="vee", spacing_m=4.5)
    assert waters.command(action="hold")[0] == 0
    assert waters.states == ["HOLD"] * 4
    assert waters.command(action="auto")[0] == 0
    assert waters.command(action="follow")[0] == 0
    assert waters.states == ["AUTO", *["FORMATION"] * 3]
    assert waters.command(action="disarm", boats=(2,))[0] == 0
    assert waters.states == ["AUTO", "DISARMED", "FORMATION", "FORMATION"]


def test_after_a_hold_boats_wait_for_a_leader_in_any_order(waters: Waters) -> None:
    """The new leader has followed boats that now follow it."""
    assert waters.command(action="form", shape="vee", spacing_m=4.5)[0] == 0
    sail(waters, 5.0)
    waters.command(action="hold")
    assert waters.command(action="form", shape="vee", spacing_m=4.5, boats=(2, 1, 3, 4))[0] == 0
    sail(waters, 3.0)
    assert waters.command(action="follow", boats=(1, 3, 4))[0] == 0
    sail(waters, 20.0)
    assert "LOITER" not in waters.states and "AUTO" not in waters.states
    waters.command(action="follow", boats=(1, 3, 4))  # a boat off its slot has stopped
    assert waters.command(action="loiter", boats=(2,))[0] == 0
    sail(waters, 5.0)
    assert waters.states == ["FORMATION", "LOITER", "FORMATION", "FORMATION"]


def test_a_boat_that_does_not_arm_gives_the_reason(waters: Waters) -> None:
    waters.command(action="stop")
    waters.fault(3, "esc_silent")
    status, words = waters.command(action="arm")
    assert status == 1
    refusal = "boat 3: refused: an ESC is offline or reports a fault"
    assert "3 of 4 armed" in words and refusal in words
    assert waters.states == ["HOLD", "HOLD", "DISARMED", "HOLD"]
    # The boat gives its reasons every ten seconds only: then its conditions tell them.
    assert refusal in waters.command(action="arm")[1]


@pytest.mark.parametrize("table", [False, True])
def test_stop_disarms_all(waters: Waters, table: bool) -> None:
    if table:
        waters.command(action="form", shape="vee", spacing_m=4.5)
    assert waters.command(action="stop")[:2] == (0, "4 of 4 stopped and disarmed\n")
    assert waters.states == ["DISARMED"] * 4
    sail(waters, 10.0)
    assert waters.states == ["DISARMED"] * 4


def test_a_boat_that_does_not_answer_the_stop_is_named(waters: Waters) -> None:
    waters.fault(2, "restart")  # and nothing starts it again
    waters.deaf.add(2)
    status, words = waters.command(action="stop", boats=BOATS)
    assert status == 1
    assert words.splitlines() == [
        "3 of 4 stopped and disarmed",
        "boat 2: no answer, and it is not heard",
    ]
    assert [waters.state(boat) for boat in (1, 3, 4)] == ["DISARMED"] * 3


@pytest.mark.parametrize(
    ("action", "command", "state"),
    [("stop", 400, "DISARMED"), ("disarm", 400, "DISARMED"), ("hold", 176, "HOLD")],
)
def test_a_late_answer_to_an_earlier_order_ends_no_stop(
    waters: Waters, action: str, command: int, state: str
) -> None:
    """Boat 2 misses the stop for 2 s; its late answer to ARM or to another mode comes meanwhile."""
    answer = mavlink.MAVLink_command_ack_message(command, 0, 0, 0, 255, COMPONENT)
    late, send = answer.pack(mavlink.MAVLink(None, 2, 1)), Air.send
    sent_s: list[float] = []

    def lossy(air: Air, frame: bytes, peer: Peer) -> None:
        (told,) = mavlink.MAVLink(None).parse_buffer(frame)
        if getattr(told, "command", None) == command and told.target_system == 2:
            sent_s.append(waters.now_s())
            if len(sent_s) == 1:
                heard(waters, late)
            if sent_s[-1] - sent_s[0] < 2.0:
                return
        send(air, frame, peer)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Air, "send", lossy)
        status, words = waters.command(action=action)
    assert waters.states == [state] * 4
    assert status == 0 and words.startswith("4 of 4 ")


def keep_saying(waters: Waters, said: bytes) -> None:
    """A stranger's messages, at all times."""
    wait = waters.wait

    def heard_too(ends: Sequence[End], for_s: float) -> Sequence[End]:
        told = wait(ends, for_s)
        heard(waters, said)
        return told

    waters.wait = heard_too


def test_a_boat_that_answers_but_stays_armed_is_named(waters: Waters) -> None:
    answer = mavlink.MAVLink_command_ack_message(400, 0, 0, 0, 255, COMPONENT)
    keep_saying(waters, beat_of(9, 1, 11, 0, 137) + answer.pack(mavlink.MAVLink(None, 9, 1)))
    status, words = waters.command(action="stop")
    assert status == 1 and words.splitlines() == [
        "4 of 5 stopped and disarmed",
        "boat 9: it answers, but no HEARTBEAT shows that it has obeyed",
    ]


def test_a_boat_that_is_heard_only_by_its_acks_counts_as_stopped(waters: Waters) -> None:
    """Another boat forwards them, but no HEARTBEAT."""
    answer = mavlink.MAVLink_command_ack_message(400, 0, 0, 0, 255, COMPONENT)
    keep_saying(waters, answer.pack(mavlink.MAVLink(None, 9, 1)))
    status, words = waters.command(action="stop", boats=(*BOATS, 9))
    assert (status, words) == (0, "5 of 5 stopped and disarmed\n")


def test_a_text_is_printed_without_control_characters(waters: Waters) -> None:
    boat = mavlink.MAVLink(None, 9, 1)
    text = mavlink.MAVLink_statustext_message(4, b"PreArm: [/dev/i2c-1] :x:\x1b[2J\r")
    refusal = mavlink.MAVLink_command_ack_message(400, 1, 0, 0, 255, COMPONENT)
    keep_saying(waters, beat_of(9, 1, 11, 0) + text.pack(boat) + refusal.pack(boat))
    _, words = waters.command(action="arm")
    assert words.splitlines()[-1] == "boat 9: refused: [/dev/i2c-1] :x:[2J"


def test_a_stop_reaches_a_boat_that_the_operators_radio_does_not(waters: Waters) -> None:
    """By the fleet's table, which members hand on."""
    waters.command(action="form", shape="vee", spacing_m=4.5)
    sail(waters, 5.0)
    waters.deaf.add(4)
    status, words = waters.command(action="stop", boats=BOATS)
    assert status == 1 and "boat 4: no answer" in words
    assert waters.states == ["DISARMED", "DISARMED", "DISARMED", "HOLD"]


def test_a_stop_reaches_the_boats_heard_within_half_a_second(waters: Waters) -> None:
    """The boats it hears stop within half a second, while others may still come up."""
    station = waters.station()
    begin_s = waters.now_s()
    stopped_s: list[float] = []
    wait = waters.wait

    def watched(ends: object, for_s: float) -> object:
        heard = wait(ends, for_s)  # type: ignore[arg-type]
        if waters.states == ["DISARMED"] * 4 and not stopped_s:
            stopped_s.append(waters.now_s() - begin_s)
        return heard

    waters.wait = watched  # type: ignore[assignment]
    stop(station, ())
    assert stopped_s and stopped_s[0] < 0.5


@pytest.mark.parametrize("seed", few(range(8), [0, 1, 2]))
def test_all_orders_get_through_a_radio_that_loses_a_third(seed: int) -> None:
    waters = Waters(loss=0.3, seed=seed + 1, boat_loss=0.3)
    assert waters.command(action="form", shape="diamond", spacing_m=4.5, boats=BOATS)[0] == 0
    assert waters.command(action="loiter", boats=(1,))[0] == 0
    assert waters.command(action="hold", boats=BOATS)[0] == 0
    assert waters.states == ["HOLD"] * 4
    assert waters.command(action="stop", boats=BOATS)[0] == 0
    assert waters.states == ["DISARMED"] * 4
    assert waters.command(action="arm", boats=BOATS)[0] == 0
    assert waters.states == ["HOLD"] * 4


class Signed:
    """The boats' messages, signed `late_s` ago, and stations with a key."""

    def __init__(self, waters: Waters, late_s: float, patch: pytest.MonkeyPatch) -> None:
        self.waters = waters
        now, wait = signing.now, waters.wait
        signers = {boat: Signer(KEY, 3) for boat in BOATS}

        def sign(peer: Peer, data: bytes) -> bytes:
            assert peer is not None
            return b"".join(signers[peer[1]].sign(frame) for *_, frame in frames(data))

        def waited(ends: Sequence[End], for_s: float) -> Sequence[End]:
            told = wait(ends, for_s)
            with pytest.MonkeyPatch.context() as then:
                then.setattr(signing, "now", lambda: now() - round(late_s * 100_000))
                for air in waters.airs:
                    air.heard = [(peer, sign(peer, data)) for peer, data in air.heard]
            return told

        patch.setattr(waters, "wait", waited)

    def command(self, key: bytes, action: str) -> tuple[int, str]:
        words, air = io.StringIO(), Air(self.waters)
        self.waters.airs.append(air)
        station = Station([air], signer=Signer(key, 70), clock=self.waters)
        status = perform(station, Wish(action), Console(file=words, width=120, highlight=False))
        self.waters.airs.pop()
        return status, words.getvalue()


def test_a_stop_reaches_boats_whose_time_differs(
    waters: Waters, monkeypatch: pytest.MonkeyPatch
) -> None:
    signed = Signed(waters, 120.0, monkeypatch)
    clock = "boats 1, 2, 3 and 4: signed with this key, but the time differs by 120 s"
    status, words = signed.command(KEY, "hold")
    assert status == 1 and words.startswith(clock) and "timedatectl" in words
    status, words = signed.command(KEY, "stop")
    assert status == 1 and words.startswith("0 of 4 stopped and disarmed\nboat 1: no answer\n")
    assert clock in words
    assert waters.states == ["DISARMED"] * 4


def test_a_wrong_key_is_reported(waters: Waters, monkeypatch: pytest.MonkeyPatch) -> None:
    signed = Signed(waters, 0.0, monkeypatch)
    assert signed.command(KEY, "hold")[0] == 0
    status, words = signed.command(bytes(32), "stop")
    assert status == 1 and words.startswith("no boat signs with this key")
    assert waters.states == ["HOLD"] * 4


def test_a_boat_that_restarts_is_armed_and_formed_again(waters: Waters) -> None:
    assert waters.command(action="form", shape="vee", spacing_m=4.5)[0] == 0
    waters.fault(4, "restart")
    sail(waters, 8.0)
    waters.fault(4, "restart", over=True)
    sail(waters, 8.0)
    _, words = waters.command(action="status")
    assert words.startswith("3 of 4 in formation behind boat 1; boat 4 is in DISARMED")
    row = words.splitlines()[-1].split()
    assert row[:2] == ["4", "DISARMED"] and "1" in row  # it got the table again
    assert waters.command(action="arm", boats=(4,))[0] == 0
    assert waters.command(action="follow", boats=(4,))[0] == 0
    assert waters.state(4) == "FORMATION"


def test_of_two_operators_the_newer_table_holds(waters: Waters) -> None:
    assert waters.command(action="form", shape="vee", spacing_m=4.5, boats=BOATS)[0] == 0
    status, words = waters.command(
        system=254, action="form", shape="column", spacing_m=4.5, boats=BOATS
    )
    assert status == 0 and words.startswith("table 2 ")


def test_a_fleet_follows_a_leader_that_is_steered_by_hand(waters: Waters) -> None:
    assert waters.command(action="form", shape="vee", spacing_m=4.5, boats=BOATS)[0] == 0
    sail(waters, 20.0)
    pilot, agent = Operator(), waters.agent(1)

    def steer(ahead: float, for_s: float) -> None:
        for _ in range(round(10.0 * for_s)):
            waters.batch.fleet.hear(agent, pilot.sticks(1, ahead), waters.t_us)
            sail(waters, 0.1)

    steer(0.0, 1.0)
    waters.batch.fleet.hear(agent, pilot.ask(1, mode_request(MANUAL)), waters.t_us)
    steer(0.0, 1.0)
    begin = waters.batch.bodies.eta[list(waters.batch.agents(0)), :2].copy()
    steer(0.2, 30.0)
    assert waters.states == ["MANUAL", *["FORMATION"] * 3]
    ways = np.hypot(*(waters.batch.bodies.eta[list(waters.batch.agents(0)), :2] - begin).T)
    assert ways.min() > 10.0
    sail(waters, 5.0)  # without sticks
    assert waters.states == ["HOLD", "LOITER", "FORMATION", "FORMATION"]


def test_a_table_is_in_force_only_with_boats_that_follow_its_leader(waters: Waters) -> None:
    def beacon(fields: tuple[int, ...]) -> Beacon:
        told = beacon_of(fields)
        return told._replace(follows=1) if told.follows == 2 else told

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sil.fleet.station.beacon_of", beacon)
        wish: dict[str, Any] = {"shape": "vee", "spacing_m": 4.5, "boats": (2, 1, 3, 4)}
        status, words = waters.command(action="form", **wish)
    assert status == 1 and words.startswith("table 1 is in force with 1 of 4 boats")
    assert "boat 3: does not report that it follows boat 2" in words


def test_acknowledgements_of_another_operators_orders_do_not_count(waters: Waters) -> None:
    one, other = waters.station(255), waters.station(254)
    other.run(2.0)
    answers = carry_out(one, long(mode_request(HOLD)), BOATS)
    other.run(0.2)
    assert all(answer.accepted for answer in answers)
    assert [len([ack for ack in each.acks if ack.command == 176]) for each in (one, other)] == [
        4,
        0,
    ]


def test_a_full_list_of_acks_does_not_hide_new_ones(
    waters: Waters,
) -> None:
    station = waters.station()
    station.run(2.0)
    station.acks = [Ack(0.0, 1, 400, 0)] * 1001
    assert all(answer.accepted for answer in carry_out(station, long(mode_request(HOLD)), BOATS))
    assert all(answer.accepted for answer in stop(station, ()))


def test_a_boat_that_obeys_another_station_only_is_reported(waters: Waters) -> None:
    waters.command(action="stop")
    wish = Operator().set_parameter(2, "MAV_GCS_SYSID", 255.0)
    waters.batch.fleet.hear(waters.agent(2), wish, waters.t_us)
    sail(waters, 1.0)
    status, words = waters.command(system=250, action="arm")
    assert status == 1
    assert "boat 2: denied: a boat whose MAV_GCS_SYSID is set obeys only that system id" in words
    assert waters.command(action="arm")[0] == 0
    # Anybody may stop it.
    assert waters.command(system=250, action="stop")[0] == 0


def test_silence_of_all_boats_is_reported(waters: Waters) -> None:
    waters.deaf.update(BOATS)
    for action in ("status", "arm", "stop", "auto"):
        status, words = waters.command(action=action)
        assert status == 1 and words.startswith("no boat is heard")


def beat_of(system: int, component: int, kind: int, autopilot: int = 8, base: int = 0) -> bytes:
    sender = mavlink.MAVLink(None, system, component)
    frame: bytes = mavlink.MAVLink_heartbeat_message(kind, autopilot, base, 0, 4, 3).pack(sender)
    return frame


def test_stations_and_ships_are_not_counted_as_boats(waters: Waters) -> None:
    """A ground station, another one under this station's id, one aboard boat 2, a ship's."""
    station = waters.station()
    (air,) = waters.airs
    for system, component, kind in ((254, 190, 6), (255, 190, 6), (2, 190, 6), (255, 1, 11)):
        air.heard.append((("stranger", 1), beat_of(system, component, kind)))
    station.run(2.0)
    assert station.boats() == list(BOATS)
    assert all(station.fleet.systems[boat].state is not None for boat in BOATS)


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        (
            {"shape": "vee", "spacing_m": 4.1},
            "places 1 and 2 are 4.10 m apart, the least is 4.18 m",
        ),
        ({"shape": "vee"}, "vee: --spacing M is missing"),
        ({"shape": "vee", "spacing_m": math.nan}, "must be greater than 0"),
        ({"shape": "ve", "spacing_m": 4.5}, 'unknown shape "ve"; did you mean "vee"?'),
        ({"shape": "vee", "spacing_m": 400.0}, "the place of boat 4 is over 327 m from boat 1's"),
        ({"shape": "vee", "spacing_m": 4.5, "boats": (1, 2, 9)}, "boat 9 is not heard"),
        ({"shape": "diamond", "spacing_m": 4.5, "boats": (1, 2, 3)}, "use 1 or 4 instead of 3"),
    ],
)
def test_an_impossible_formation_is_refused(
    waters: Waters, wish: dict[str, Any], said: str
) -> None:
    sent: list[bytes] = []
    send = Air.send

    def listening(air: Air, frame: bytes, peer: Peer) -> None:
        sent.append(frame)
        send(air, frame, peer)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Air, "send", listening)
        with pytest.raises(ValueError, match=re.escape(said)):
            waters.command(action="form", **wish)
    ear = Ear(stream=False)
    assert FLEET_TABLE not in {message.number for frame in sent for message in ear.hear(frame)}


def test_orders_to_an_unknown_leader_are_refused(waters: Waters) -> None:
    waters.command(action="stop")
    with pytest.raises(ValueError, match=r"vessel 100 leads.*--boats N"):
        waters.command(action="auto")
    with pytest.raises(ValueError, match="auto commands only the leader"):
        waters.command(action="auto", boats=(1, 2))


def test_places_are_assigned_so_that_squared_distances_are_least() -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        places = [(0.0, 0.0), *map(tuple, rng.uniform(-20, 20, (5, 2)))]
        present = [(0.0, 0.0), *map(tuple, rng.uniform(-20, 20, (5, 2)))]
        given = assigned(places, present)
        assert given[0] == places[0] and sorted(given) == sorted(places)

        def cost(
            order: list[tuple[float, float]], present: list[tuple[float, float]] = present
        ) -> float:
            return sum(math.dist(a, b) ** 2 for a, b in zip(order, present, strict=True))

        best = min(cost([places[0], *rest]) for rest in permutations(places[1:]))
        assert cost(given) == pytest.approx(best)


def test_all_shapes_keep_their_spacing() -> None:
    for shape in ("line", "column", "vee", "circle", "grid"):
        places = shape_places(shape, 7, 5.0)
        assert places[0] == (0.0, 0.0)
        assert min(math.dist(*pair) for pair in combinations(places, 2)) == pytest.approx(5.0)
