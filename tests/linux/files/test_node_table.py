# SPDX-License-Identifier: MIT
"""A motor controller without a node id is allocated one, and keeps it."""

import signal
from typing import Any

from tests.linux.process import RealSea
from tests.target.bus import NODE, of_type, reference, transfers

ALLOCATION = 1
LOG = next(entry for entry in reference("generated") if entry["name"] == "spec DNA log")
FIRST = bytes.fromhex(LOG["values"]["unique_id"])
SECOND = bytes(range(16))
PARTS = (slice(0, 6), slice(6, 12), slice(12, 16))


def request(unique_id: bytes, part: int) -> tuple[int, bytes]:
    """An anonymous node's request: priority, 14 random bits, 2 bits of the data type."""
    chance = 0x3BA0 + part
    payload = bytes([part == 0]) + unique_id[PARTS[part]]
    return 0x1E << 24 | chance << 10 | ALLOCATION << 8, payload + bytes([0xC0 | part])


def answers(sea: RealSea) -> list[Any]:
    own = [frame for frame in of_type(sea.frames(), ALLOCATION) if frame[0] & 0x7F]
    return [t.payload for t in transfers(own) if t.source_node_id == NODE]


def allocated(sea: RealSea, unique_id: bytes) -> int:
    """Act as such a node until it has its id."""
    sea.until(sea.ready)
    for part in range(3):
        before = len(answers(sea))
        sea.send_can(*request(unique_id, part))
        sea.until(lambda before=before: len(answers(sea)) > before)
        told = bytes(answers(sea)[-1].unique_id)
        assert told == unique_id[: PARTS[part].stop]
    return int(answers(sea)[-1].node_id)


def test_an_allocation_request_is_answered_as_in_the_specifications_log(sea: RealSea) -> None:
    frames = [frame.split("#") for frame in LOG["frames"]]
    asked = [bytes.fromhex(data) for can_id, data in frames if can_id.endswith("00")]
    assert [request(FIRST, part)[1] for part in range(3)] == asked
    sea.start()
    assert allocated(sea, FIRST) == LOG["values"]["allocated"]
    logged = [(int(i, 16), bytes.fromhex(data)) for i, data in frames if i.endswith("01")]
    expected = [t.payload for t in transfers(logged)]
    assert [(a.node_id, bytes(a.unique_id)) for a in answers(sea)] == [
        (e.node_id, bytes(e.unique_id)) for e in expected
    ]


def test_nodes_keep_their_ids_whoever_asks_first_after_a_restart(sea: RealSea) -> None:
    table = sea.state_dir / "node_ids.txt"
    sea.start()
    first, second = allocated(sea, FIRST), allocated(sea, SECOND)
    assert first != second
    sea.until(lambda: table.exists() and len(table.read_text().splitlines()) == 2)
    sea.end(signal.SIGKILL)  # it is on the disk already

    sea.start()
    assert [allocated(sea, SECOND), allocated(sea, FIRST)] == [second, first]
    assert sea.end() == 0
    assert len(table.read_text().splitlines()) == 2


def test_a_line_of_the_table_that_makes_no_sense_spoils_no_other(sea: RealSea) -> None:
    sea.state_dir.mkdir()
    lines = ["what is this", "", f"{FIRST.hex()} 500", f"{SECOND.hex()} 77"]
    (sea.state_dir / "node_ids.txt").write_text("\n".join(lines) + "\n")
    sea.start()
    assert allocated(sea, SECOND) == 77
    assert allocated(sea, FIRST) == LOG["values"]["allocated"]


def test_a_failed_write_is_reported_once_and_tried_again(sea: RealSea) -> None:
    table = sea.state_dir / "node_ids.txt"
    obstacle = sea.state_dir / "node_ids.txt.new"
    obstacle.mkdir(parents=True)
    sea.start()
    allocated(sea, FIRST)
    sea.until(lambda: "node_ids.txt.new cannot be written" in sea.process.words)
    sea.run(6.0)  # it has been tried again
    assert sea.process.words.count("node_ids.txt.new cannot be written") == 1
    obstacle.rmdir()
    sea.until(table.exists)
    assert sea.end() == 0
    assert table.read_text() == f"{FIRST.hex()} {LOG['values']['allocated']}\n"
