# SPDX-License-Identifier: MIT
"""A plan survives the end of flotillad, however sudden; a damaged file is reported, not used."""

import signal
import zlib
from collections.abc import Callable, Sequence

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.linux.process import PATIENT, RealSea
from tests.target.plans import Item, as_sent, at, box, circle, fields, rally, speed
from tests.target.stations import ARM, BOAT

PLAN = [at(10, 0, hold_s=3.0), speed(0.8), at(10, 10, radius_m=1.5)]
OTHER = [at(5, 5)]


FENCED = [*box(0, 0, 60), circle(0, 0, 50)]
KEPT = {
    "plan": (PLAN, OTHER),
    "fence": (FENCED, FENCED[-1:]),
    "rally": ([rally(1, 2)] * 2, [rally(3, 4)]),
}
KIND = {"plan": 0, "fence": 1, "rally": 2}


def send(sea: RealSea, items: Sequence[Item], kind: int = 0) -> None:
    """Send a plan and wait for its acceptance."""
    sea.until(sea.ready)
    acknowledged, asked = len(sea.named("MISSION_ACK")), len(sea.named("MISSION_REQUEST_INT"))
    sea.say(mavlink.MAVLink_mission_count_message(BOAT, 1, len(items), kind))
    for seq, item in enumerate(items):
        sea.until(
            lambda seq=seq: [m.seq for m in sea.named("MISSION_REQUEST_INT")[asked:]][-1:] == [seq]
        )
        sea.say(item.message(seq, kind=kind))
    sea.until(lambda: len(sea.named("MISSION_ACK")) > acknowledged)
    assert sea.named("MISSION_ACK")[-1].type == 0


def fetched(sea: RealSea, kind: int = 0) -> list[tuple[bytes, ...]]:
    """The boat's plan."""
    sea.until(sea.ready)
    told = len(sea.named("MISSION_COUNT"))
    sea.say(mavlink.MAVLink_mission_request_list_message(BOAT, 1, kind))
    sea.until(lambda: len(sea.named("MISSION_COUNT")) > told)
    items = []
    for seq in range(sea.named("MISSION_COUNT")[-1].count):
        given = len(sea.named("MISSION_ITEM_INT"))
        sea.say(mavlink.MAVLink_mission_request_int_message(BOAT, 1, seq, kind))
        sea.until(lambda given=given: len(sea.named("MISSION_ITEM_INT")) > given)
        items.append(fields(sea.named("MISSION_ITEM_INT")[-1]))
    return items


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("name", KEPT)
def test_stored_plans_are_there_after_a_restart(
    sea: RealSea, name: str, end: signal.Signals
) -> None:
    first, second = KEPT[name]
    kind = KIND[name]
    sea.start()
    send(sea, first, kind)
    file = sea.state_dir / f"{name}.txt"
    if end == signal.SIGKILL:
        lines = len(first) + 2
        sea.until(lambda: file.exists() and len(file.read_text().splitlines()) == lines)
    sea.end(end)
    sea.start()
    assert fetched(sea, kind) == as_sent(first)
    send(sea, second, kind)
    sea.end()
    sea.start()
    assert fetched(sea, kind) == as_sent(second)


def test_a_cleared_plan_stays_cleared(sea: RealSea) -> None:
    sea.start()
    send(sea, PLAN)
    sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, 0))
    sea.until(lambda: len(sea.named("MISSION_ACK")) > 1)
    sea.end()
    sea.start()
    assert fetched(sea) == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[:40], "plan.txt is damaged; no plan"),
        (lambda text: text.replace("16 6 1", "16 6 0", 1), "plan.txt is damaged; no plan"),
    ],
    ids=["cut", "changed"],
)
def test_a_damaged_file_is_reported_and_not_used(
    sea: RealSea, change: Callable[[str], str], words: str
) -> None:
    sea.start()
    send(sea, PLAN)
    sea.end()
    file = sea.state_dir / "plan.txt"
    file.write_text(change(file.read_text()))
    sea.start()
    assert fetched(sea) == []
    sea.until(lambda: words in sea.process.words)


def test_a_boat_whose_fence_cannot_be_saved_reports_it_and_does_not_arm(sea: RealSea) -> None:
    obstacle = sea.state_dir / "fence.txt.new"
    sea.start()
    sea.until(sea.ready)
    obstacle.mkdir()
    send(sea, FENCED, 1)
    sea.until(lambda: "fence could not be saved: see the host's disk" in sea.texts())
    sea.insist(lambda: "PreArm: parameters or fence are not saved" in sea.texts(), ARM, 1.0)
    assert not sea.armed
    obstacle.rmdir()
    sea.arm()


@pytest.mark.parametrize("lost", ["damaged", "refused"])
@pytest.mark.parametrize("new", ["sent", "cleared"])
def test_a_boat_that_cannot_use_its_stored_fence_does_not_arm_until_it_has_a_new_one_or_none(
    sea: RealSea, lost: str, new: str
) -> None:
    sea.start()
    send(sea, FENCED, 1)
    sea.end()
    file = sea.state_dir / "fence.txt"
    if lost == "damaged":
        file.write_text(file.read_text()[:40])
    else:
        lines = file.read_text().splitlines(keepends=True)
        body = "".join(lines[:2])  # one corner is no polygon
        file.write_text(body + f"crc32 = {zlib.crc32(body.encode()):08X}\n")
    sea.start()
    said = {"damaged": "fence.txt is damaged; no fence", "refused": "fence.txt is not used: "}
    sea.until(lambda: said[lost] in sea.process.words)
    sea.insist(lambda: "PreArm: parameters or fence are not saved" in sea.texts(), ARM, 1.0)
    assert "stored fence is not usable: send or clear it" in sea.texts()
    assert not sea.armed
    if new == "sent":
        send(sea, FENCED[-1:], 1)
    else:
        sea.say(mavlink.MAVLink_mission_clear_all_message(BOAT, 1, 1))
    sea.arm()
    sea.end()
    sea.start()
    assert fetched(sea, 1) == (as_sent(FENCED[-1:]) if new == "sent" else [])
    sea.arm()


def test_a_plan_with_a_speed_above_a_lowered_limit_is_kept(sea: RealSea) -> None:
    sea.start()
    send(sea, PLAN)
    sea.end()
    sea.start(param=PATIENT | {"LAW_U_MAX": 0.5})
    assert fetched(sea) == as_sent(PLAN)


def test_a_stored_plan_that_no_boat_can_sail_is_not_used(sea: RealSea) -> None:
    sea.start()
    send(sea, PLAN)
    sea.end()
    file = sea.state_dir / "plan.txt"
    body = "".join(file.read_text().splitlines(keepends=True)[:-1]).replace("16 ", "22 ", 1)
    file.write_text(body + f"crc32 = {zlib.crc32(body.encode()):08X}\n")
    sea.start()
    assert fetched(sea) == []
    sea.until(lambda: "plan.txt is not used: " in sea.process.words)
