# SPDX-License-Identifier: MIT
"""Frames of the state against pymavlink's own packing."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sil.wire.state_frame import StateFrame

FLOAT32 = st.floats(width=32, allow_nan=False)
BYTE = st.integers(0, 255)


@pytest.mark.parametrize(
    "message_class", [mavlink.MAVLink_attitude_message, mavlink.MAVLink_local_position_ned_message]
)
@given(
    system=BYTE,
    component=BYTE,
    sequence=BYTE,
    ms=st.integers(0, 2**32 - 1),
    values=st.tuples(*[FLOAT32 | st.just(0.0)] * 6),
)
def test_a_frame_is_pymavlinks_byte_for_byte(
    message_class: type,
    system: int,
    component: int,
    sequence: int,
    ms: int,
    values: tuple[float, ...],
) -> None:
    mav = mavlink.MAVLink(None, system, component)
    mav.seq = sequence
    frame = StateFrame(message_class, system, component).pack(sequence, ms, *values)
    assert frame == message_class(ms, *values).pack(mav)


def test_a_value_beyond_float32_is_an_error() -> None:
    frame = StateFrame(mavlink.MAVLink_attitude_message, 1, 1)
    with pytest.raises((struct.error, OverflowError)):
        frame.pack(0, 0, 1e300, 0.0, 0.0, 0.0, 0.0, 0.0)
