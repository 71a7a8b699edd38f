# SPDX-License-Identifier: MIT
"""The operator's half of the mission protocol, against pymavlink's messages."""

from collections.abc import Callable

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.wire.operator import COMPONENT, SYSTEM, plan_upload
from sil.wire.plan_upload import PlanItem, PlanUpload, speed_item, waypoint_item

BOAT = 7
ITEMS = [speed_item(0.5), waypoint_item(487_000_000, 22_950_000, 0.0)]
SECOND = 1_000_000


def read(data: bytes) -> list[mavlink.MAVLink_message]:
    return mavlink.MAVLink(None).parse_buffer(bytearray(data)) or []


def answer(message: mavlink.MAVLink_message, system: int = BOAT) -> bytes:
    packed: bytes = message.pack(mavlink.MAVLink(None, system, 1))
    return packed


def ask(seq: int, kind: int = 0) -> bytes:
    return answer(mavlink.MAVLink_mission_request_int_message(SYSTEM, COMPONENT, seq, kind))


def ack(result: int, kind: int = 0) -> bytes:
    return answer(mavlink.MAVLink_mission_ack_message(SYSTEM, COMPONENT, result, kind))


def begun(items: list[PlanItem] = ITEMS) -> PlanUpload:
    upload = plan_upload(BOAT, items)
    (count,) = read(upload.say(0))
    assert (count.get_type(), count.count) == ("MISSION_COUNT", len(items))
    return upload


def test_a_boat_that_asks_gets_every_item() -> None:
    upload = begun()
    for seq in (0, 1, 1):
        upload.on_mavlink(ask(seq), SECOND)
        (item,) = read(upload.say(SECOND))
        assert (item.seq, item.command) == (seq, ITEMS[seq].command)
        assert (item.x, item.y) == (ITEMS[seq].latitude, ITEMS[seq].longitude)
    upload.on_mavlink(ack(mavlink.MAV_MISSION_ACCEPTED), SECOND)
    assert upload.done and not upload.fault and upload.say(100 * SECOND) == b""


def test_a_silent_boat_is_asked_five_times() -> None:
    upload = begun()
    said = [t for t in range(0, 20 * SECOND, 100_000) if upload.say(t)]
    assert said == [1_500_000, 3_000_000, 4_500_000, 6_000_000]
    assert not upload.done and upload.fault == "the boat does not answer"


def test_a_refusal_is_reported() -> None:
    upload = begun()
    upload.on_mavlink(ack(mavlink.MAV_MISSION_INVALID_PARAM2), 0)
    assert not upload.done and upload.fault == "MAV_MISSION_INVALID_PARAM2"


@pytest.mark.parametrize(
    "damaged",
    [
        lambda: ask(5),
        lambda: ask(0, mavlink.MAV_MISSION_TYPE_FENCE),
        lambda: ack(mavlink.MAV_MISSION_ACCEPTED, mavlink.MAV_MISSION_TYPE_RALLY),
        lambda: answer(mavlink.MAVLink_mission_ack_message(9, COMPONENT, 0, 0)),
        lambda: answer(mavlink.MAVLink_mission_ack_message(SYSTEM, COMPONENT, 0, 0), system=8),
    ],
)
def test_messages_that_do_not_belong_to_the_upload_change_nothing(
    damaged: Callable[[], bytes],
) -> None:
    upload = begun()
    upload.on_mavlink(damaged(), SECOND)
    assert upload.say(SECOND) == b"" and not upload.done and not upload.fault


def test_the_firmware_accepts_it() -> None:
    boat = flotilla.Boat({"MAV_SYSID": BOAT})
    upload = plan_upload(BOAT, ITEMS)
    for t_us in range(0, 5 * SECOND, 10_000):
        if data := upload.say(t_us):
            boat.on_mavlink(data, t_us, 0)
        for _, said in boat.tick(t_us).mavlink:
            upload.on_mavlink(said, t_us)
    assert upload.done
