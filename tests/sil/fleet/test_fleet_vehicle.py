# SPDX-License-Identifier: MIT
"""The fleet as one vehicle, against the firmware: what a ground station says, what the boats do."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.ends import End, Peer
from sil.fleet.fleet_vehicle import FleetVehicle
from sil.fleet.vehicle_commands import wish_of
from sil.wire.fleet_table import Member, table_message
from sil.wire.heartbeat import AUTO, FORMATION, HOLD, LOITER, MANUAL
from sil.wire.signing import Signer
from tests.sil.fleet.waters import BOATS, Waters, beacon_message, heard

FLEET = 250
ARM, MODE, GO = 400, 176, 192
ACCEPTED, DENIED, UNSUPPORTED, FAILED, IN_PROGRESS, CANCELLED = 0, 2, 3, 4, 5, 6
KEY = bytes(range(32))


class Ground(End):
    """A ground station at the other side of the vehicle's end."""

    address = "ground"

    def __init__(self, key: bytes | None = None) -> None:
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.signer = None if key is None else Signer(key, 3)
        self.heard: list[mavlink.MAVLink_message] = []
        self._sent: list[tuple[Peer, bytes]] = []
        self.frames: list[bytes] = []
        self.later: list[tuple[float, Callable[[], None]]] = []
        self.now_s: Callable[[], float] = lambda: 0.0
        self._ear = mavlink.MAVLink(None)

    def say(self, message: mavlink.MAVLink_message) -> None:
        frame = message.pack(self.mav)
        self.mav.seq = (self.mav.seq + 1) & 0xFF
        self._sent.append((None, frame if self.signer is None else self.signer.sign(frame)))

    def command(self, number: int, *params: float, target: int = FLEET) -> None:
        seven = (*params, *(0.0,) * (7 - len(params)))
        self.say(mavlink.MAVLink_command_long_message(target, 1, number, 0, *seven))

    def mode(self, mode: int) -> None:
        self.command(MODE, 1.0, float(mode))

    def answers(self, number: int) -> list[int]:
        """The results so far, each once."""
        told = [m.result for m in self.of("COMMAND_ACK") if m.command == number]
        return list(dict.fromkeys(told))

    def of(self, kind: str) -> list[mavlink.MAVLink_message]:
        return [message for message in self.heard if message.get_type() == kind]

    def texts(self) -> str:
        return "".join(message.text for message in self.of("STATUSTEXT"))

    def fileno(self) -> int:
        raise NotImplementedError

    def receive(self) -> list[tuple[Peer, bytes]]:
        while self.later and self.later[0][0] <= self.now_s():
            self.later.pop(0)[1]()
        sent, self._sent = self._sent, []
        return sent

    def send(self, frame: bytes, peer: Peer) -> None:
        assert peer is None
        self.frames.append(frame)
        self.heard += self._ear.parse_buffer(frame) or []

    def close(self) -> None:
        pass


class Served:
    """Four boats under way, and the vehicle that stands for them."""

    def __init__(self, key: bytes | None = None, ground_key: bytes | None = None) -> None:
        self.waters = Waters()
        self.ground = Ground(ground_key or key)
        self.station = self.waters.station()
        self.ground.now_s = self.station.now_s
        signer = None if key is None else Signer(key, 71)
        self.vehicle = FleetVehicle(self.station, self.ground, FLEET, signer)
        self.vehicle.serve(3.0)

    def run(self, for_s: float) -> None:
        self.vehicle.serve(for_s)
        print(f"states {self.states}, told {self.ground.texts()}")

    @property
    def states(self) -> Sequence[str]:
        return self.waters.states


@pytest.fixture
def served() -> Served:
    return Served()


def test_it_reports_the_leaders_mode_and_position_and_the_fleets_status(served: Served) -> None:
    beats = served.ground.of("HEARTBEAT")
    assert len(beats) == 3
    last = beats[-1]
    assert (last.get_srcSystem(), last.get_srcComponent()) == (FLEET, 1)
    assert last.type == mavlink.MAV_TYPE_SURFACE_BOAT
    assert (last.custom_mode, last.base_mode & 128) == (AUTO, 128)
    assert last.system_status == mavlink.MAV_STATE_ACTIVE
    told = served.ground.of("GLOBAL_POSITION_INT")[-1]
    leader = [m for m in [served.station.fleet.vessels(served.station.now_s())[0]] if m["id"] == 1]
    speed = math.hypot(told.vx, told.vy)
    assert leader and 30 < speed < 150
    assert "4 of 4 in formation behind boat 1" in served.ground.texts()


def test_the_fleet_waits_and_goes_on_with_its_leader(served: Served) -> None:
    served.ground.mode(LOITER)
    served.run(4.0)
    assert served.ground.answers(MODE) == [IN_PROGRESS, ACCEPTED]
    assert list(served.states) == ["LOITER", "FORMATION", "FORMATION", "FORMATION"]
    assert served.ground.of("HEARTBEAT")[-1].custom_mode == LOITER
    served.ground.mode(AUTO)
    served.run(4.0)
    assert list(served.states) == ["AUTO", "FORMATION", "FORMATION", "FORMATION"]


def test_after_hold_the_leaders_next_mode_brings_followers_back_to_formation(
    served: Served,
) -> None:
    served.ground.mode(HOLD)
    served.run(4.0)
    assert list(served.states) == ["HOLD"] * 4
    served.ground.mode(AUTO)
    served.run(8.0)
    assert list(served.states) == ["AUTO", "FORMATION", "FORMATION", "FORMATION"]


def test_the_fleet_goes_to_a_place(served: Served) -> None:
    here = served.ground.of("GLOBAL_POSITION_INT")[-1]
    served.ground.say(
        mavlink.MAVLink_command_int_message(
            *(FLEET, 1, 6, GO, 0, 0, -1.0, 1.0, 0.0, 0.0),
            *(here.lat + 3000, here.lon, 0.0),
        )
    )
    served.run(4.0)
    assert served.ground.answers(GO) == [IN_PROGRESS, ACCEPTED]
    assert list(served.states) == ["GUIDED", "FORMATION", "FORMATION", "FORMATION"]


def test_only_boats_in_hold_follow_when_the_leader_is_sent_to_sail() -> None:
    served = Served()
    waters, pilot, sail_on = served.waters, mavlink.MAVLink(None, 249, 190), served.waters.wait

    def tell(boat: int, message: mavlink.MAVLink_message) -> None:
        pilot.seq = (pilot.seq + 1) & 0xFF
        waters.batch.fleet.hear(waters.agent(boat), message.pack(pilot), waters.t_us)

    def wait(ends: Sequence[End], for_s: float) -> Sequence[End]:
        tell(3, mavlink.MAVLink_manual_control_message(3, 0, 0, 500, 0, 0))
        return sail_on(ends, for_s)

    waters.wait = wait
    served.run(0.5)
    tell(3, mavlink.MAVLink_set_mode_message(3, 1, MANUAL))
    tell(4, mavlink.MAVLink_set_mode_message(4, 1, HOLD))
    served.run(3.0)
    assert list(served.states) == ["AUTO", "FORMATION", "MANUAL", "HOLD"]
    served.ground.mode(LOITER)
    served.run(6.0)
    assert list(served.states) == ["LOITER", "FORMATION", "MANUAL", "FORMATION"]


def test_requests_that_a_boat_refuses_do_not_move_the_fleet(served: Served) -> None:
    here = served.ground.of("GLOBAL_POSITION_INT")[-1]
    served.ground.mode(HOLD)
    served.run(6.0)
    served.ground.command(MODE, 1.0, 6.0, 0.0, *[math.nan] * 4)  # MAVSDK's start of OFFBOARD
    served.ground.say(  # moves the target of a boat in GUIDED only
        mavlink.MAVLink_command_int_message(
            *(FLEET, 1, 6, GO, 0, 0, -1.0, 0.0, 0.0, 0.0),
            *(here.lat + 3000, here.lon, 0.0),
        )
    )
    served.run(8.0)
    assert list(served.states) == ["HOLD"] * 4


@pytest.mark.parametrize("first", [FORMATION, HOLD])
def test_disarming_stops_every_boat_and_cancels_pending_commands(
    served: Served, first: int
) -> None:
    served.waters.deaf.add(4)
    ground, now_s = served.ground, served.station.now_s()
    stopped: list[str] = []
    ground.later = [
        (now_s, lambda: ground.mode(first)),  # takes six seconds, as boat 4 does not answer
        (now_s + 1.0, lambda: ground.mode(AUTO)),
        (now_s + 2.0, lambda: ground.command(ARM, 0.0)),
        (now_s + 2.5, lambda: stopped.extend(served.states)),
        (now_s + 5.0, served.waters.deaf.clear),
    ]
    served.run(8.0)
    assert stopped[:3] == ["DISARMED"] * 3
    assert list(served.states) == ["DISARMED"] * 4
    assert [m.result for m in ground.of("COMMAND_ACK") if m.command == MODE] == [
        *(IN_PROGRESS, IN_PROGRESS),
        *(CANCELLED, CANCELLED),
    ]
    assert served.ground.answers(ARM) == [IN_PROGRESS, ACCEPTED]
    assert served.ground.of("HEARTBEAT")[-1].base_mode & 128 == 0


def test_a_stop_repeated_while_it_is_carried_out_cancels_what_was_asked_between(
    served: Served,
) -> None:
    served.waters.deaf.add(4)
    ground, now_s = served.ground, served.station.now_s()
    ground.later = [
        (now_s, lambda: ground.mode(HOLD)),  # takes six seconds, as boat 4 does not answer
        (now_s + 1.0, lambda: ground.mode(AUTO)),
        (now_s + 2.0, lambda: ground.mode(HOLD)),
        (now_s + 4.0, served.waters.deaf.clear),
    ]
    served.run(14.0)
    assert list(served.states) == ["HOLD"] * 4
    assert CANCELLED in served.ground.answers(MODE)


def test_a_boat_that_does_not_obey_is_named(served: Served) -> None:
    served.waters.deaf.add(3)
    served.ground.mode(HOLD)
    served.run(12.0)
    assert served.ground.answers(MODE) == [IN_PROGRESS, FAILED]
    assert "boat 3: no answer" in served.ground.texts()
    assert served.ground.of("HEARTBEAT")[-1].system_status == mavlink.MAV_STATE_CRITICAL


@pytest.mark.parametrize("silent_s", [6.0, 70.0])
def test_a_silent_fleet_keeps_its_last_state(served: Served, silent_s: float) -> None:
    served.waters.deaf.update(BOATS)
    served.run(silent_s)
    last = served.ground.of("HEARTBEAT")[-1]
    assert (last.custom_mode, last.base_mode & 128) == (AUTO, 128)
    assert last.system_status == mavlink.MAV_STATE_CRITICAL


def test_a_beacon_of_an_unknown_system_changes_nothing(served: Served) -> None:
    heard(served.waters, beacon_message(77, 1, 5))
    served.ground.mode(FORMATION)
    served.run(15.0)
    assert served.ground.answers(MODE) == [IN_PROGRESS, ACCEPTED]
    assert served.ground.of("HEARTBEAT")[-1].system_status == mavlink.MAV_STATE_ACTIVE
    assert "77" not in served.ground.texts()


def test_a_command_that_is_repeated_is_carried_out_once(served: Served) -> None:
    for _ in range(4):
        served.ground.mode(LOITER)
    served.run(6.0)
    told = [m.result for m in served.ground.of("COMMAND_ACK")]
    assert told == [IN_PROGRESS] * 4 + [ACCEPTED]


@pytest.mark.parametrize(
    ("number", "params", "result"),
    [
        (MODE, (1.0, 0.0), DENIED),  # MANUAL
        (MODE, (1.0, 99.0), DENIED),
        (MODE, (0.0, float(AUTO)), DENIED),
        (MODE, (1.0, float(AUTO), 4.0), DENIED),  # PX4's sub mode
        (MODE, (math.nan, math.nan), DENIED),
        (ARM, (1.0, 21196.0), DENIED),
        (ARM, (0.5,), DENIED),
        (GO, (0, 1, 0, 0, math.nan, math.nan), DENIED),
        (GO, (0, 1, 0, 0, 91.0, 0.0), DENIED),
        (GO, (2.0, 1, 0, 0, 60.0, 5.0), DENIED),  # a speed
        (22, (), UNSUPPORTED),
    ],
)
def test_requests_that_make_no_sense_for_a_fleet_are_refused(
    served: Served, number: int, params: tuple[float, ...], result: int
) -> None:
    before = list(served.states)
    served.ground.command(number, *params)
    served.run(1.0)
    assert served.ground.answers(number) == [result]
    assert list(served.states) == before


def test_commands_to_others_are_not_the_fleets(served: Served) -> None:
    served.ground.command(ARM, 0.0, target=1)
    served.run(3.0)
    assert not served.ground.answers(ARM)
    assert "DISARMED" not in served.states


def test_a_ground_station_without_the_key_is_ignored() -> None:
    served = Served(key=KEY, ground_key=bytes(32))
    served.ground.command(ARM, 0.0)
    served.run(3.0)
    assert not served.ground.of("COMMAND_ACK")
    assert "DISARMED" not in served.states


def test_a_ground_station_with_the_key_is_obeyed_and_gets_signed_answers() -> None:
    served = Served(key=KEY)
    served.ground.command(ARM, 0.0)
    served.run(4.0)
    assert served.ground.answers(ARM) == [IN_PROGRESS, ACCEPTED]
    assert served.ground.frames and all(frame[2] & 1 for frame in served.ground.frames)


def test_boats_miss_the_ground_station_when_it_falls_silent(served: Served) -> None:
    assert served.station.kind == mavlink.MAV_TYPE_ONBOARD_CONTROLLER
    served.ground.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    served.run(1.0)
    assert served.station.kind == mavlink.MAV_TYPE_GCS
    served.run(3.0)
    assert served.station.kind == mavlink.MAV_TYPE_ONBOARD_CONTROLLER


def test_a_system_id_of_a_boat_is_refused() -> None:
    waters = Waters()
    vehicle = FleetVehicle(waters.station(), Ground(), BOATS[1])
    with pytest.raises(ValueError, match="already has system id 2"):
        vehicle.serve(3.0)


def test_an_echo_of_its_own_heartbeat_is_reported_once_and_ignored(served: Served) -> None:
    for _ in range(3):
        heard(served.waters, served.ground.frames[0])
        served.run(2.0)
    assert served.ground.texts().count("messages with system id 250 among the boats") == 1
    assert served.station.boats() == list(BOATS)
    served.ground.command(ARM, 0.0)
    served.run(4.0)
    assert served.ground.answers(ARM) == [IN_PROGRESS, ACCEPTED]


def test_a_strangers_message_with_its_id_does_not_end_it(served: Served) -> None:
    served.run(3.0)
    heard(served.waters, beacon_message(FLEET, 1, 5))
    served.run(3.0)
    assert "messages with system id 250 among the boats are ignored" in served.ground.texts()


def test_garbage_is_ignored(served: Served) -> None:
    served.ground._sent.append((None, b"\xfd\x09" + bytes(range(256)) * 3))
    served.ground.mode(LOITER)
    served.run(4.0)
    assert served.states[0] == "LOITER"


def test_a_place_in_a_local_frame_is_no_place_on_the_globe(served: Served) -> None:
    go = (FLEET, 1, mavlink.MAV_FRAME_LOCAL_NED, GO, 0, 0, -1.0, 1.0, 0.0, 0.0, 200000, 0, 0.0)
    served.ground.say(mavlink.MAVLink_command_int_message(*go))
    served.run(1.0)
    assert served.ground.answers(GO) == [DENIED]


def test_a_message_that_pymavlink_does_not_know_is_ignored(served: Served) -> None:
    table = table_message(1, [Member(system=1, leader=0, place_m=(0.0, 0.0), length_m=1.0)])
    served.ground._sent.append((None, table))
    served.ground.mode(LOITER)
    served.run(4.0)
    assert served.states[0] == "LOITER"


def test_hold_of_mavsdk_means_hold(served: Served) -> None:
    served.ground.command(MODE, 1.0, 4.0, 3.0)
    served.run(4.0)
    assert list(served.states) == ["HOLD"] * 4


def test_set_mode_is_accepted() -> None:
    wish = wish_of(mavlink.MAVLink_set_mode_message(FLEET, 1, HOLD))
    assert wish is not None and wish.action == "hold"
