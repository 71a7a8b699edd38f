# SPDX-License-Identifier: MIT
"""Another system claims the boat's slot: without a table, and as a stranger to the one in force."""

from __future__ import annotations

from typing import Any

import pytest

from sil.wire.fleet_table import Member, table_message
from tests.dialect import dialect
from tests.target.course import TURN
from tests.target.hull import Afloat
from tests.target.sea import Sea, messages
from tests.target.stations import BOAT, LEADER, STRANGER, Station


def claim(sea: Sea, own: Any) -> Any:
    """The boat's own FORMATION_REFERENCE, told by another system of the same leader."""
    fields = {name: getattr(own, name) for name in own.fieldnames}
    fields |= {"time_boot_ms": sea.now_us // 1000, "sequence": sea.now_us // 100_000 % 2**16}
    fields |= {"maker": STRANGER, "flags": 1, "path": [LEADER] + [0] * 23}
    return dialect().MAVLink_formation_reference_message(**fields)


@pytest.mark.parametrize("listed", [None, BOAT, STRANGER])
def test_only_members_of_a_table_in_force_can_claim_a_slot_that_it_gives(
    listed: int | None,
) -> None:
    sea = Afloat({"LAW_REF": 1.0}, leader=TURN)
    sea.enter_formation()
    sea.run(2.0)
    if listed:
        members = [Member(LEADER, 0, (0, 0), 1.3, only_leads=True)]
        members += [Member(BOAT, LEADER, (-4, -4), 1.3)]
        if listed == STRANGER:
            members += [Member(STRANGER, LEADER, (-8, -8), 1.3)]
        sea.boat.on_mavlink(table_message(1, members), sea.now_us)
        sea.run(3.0)
    told = [m for m in messages(sea.ticks[-100:]) if m.get_type() == "FORMATION_REFERENCE"]
    rival = Station(STRANGER)
    for _ in range(80):
        sea.say(claim(sea, told[-1]), sender=rival)
        sea.run(0.1)
    assert sea.state == ("FORMATION" if listed == BOAT else "HOLD")
