# SPDX-License-Identifier: MIT
"""The state decoded from a HEARTBEAT, against the firmware's state."""

import flotilla
import pytest

from sil.wire.heartbeat import state_of
from tests.target.operator_words import ENTER
from tests.target.sea import Sea, named


def told(sea: Sea) -> str | None:
    """The state in the last HEARTBEAT."""
    beat = named(sea.ticks, "HEARTBEAT")[-1]
    return state_of(beat.custom_mode, beat.base_mode, beat.system_status)


@pytest.mark.parametrize("state", flotilla.STATES)
def test_the_state_read_in_a_heartbeat_is_the_boats(state: str) -> None:
    sea = Sea()
    if state == "COAST":
        ENTER["FORMATION"](sea)
        sea.silence("leader")
        sea.run_until("COAST", 2.0)
    else:
        ENTER[state](sea)
    assert sea.state == state and told(sea) == state


def test_a_mode_that_the_firmware_does_not_have_is_no_state() -> None:
    assert state_of(17, 129, 4) is None
