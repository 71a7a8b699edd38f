# SPDX-License-Identifier: MIT
"""Finding MAVLink frames in clean and damaged bytes."""

from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sil.wire.mavlink_frames import frames

Frame = tuple[int, int, int, bytes]
CLEAN = st.binary(max_size=40).map(lambda b: b.replace(b"\xfd", b"\xfc"))


@st.composite
def mavlink_frame(draw: st.DrawFn) -> Frame:
    system, component = draw(st.integers(1, 254)), draw(st.integers(1, 254))
    mav = mavlink.MAVLink(None, system, component)
    mav.seq = draw(st.integers(0, 255))
    integers = st.integers(-(1 << 63), (1 << 63) - 1)
    message = draw(
        st.one_of(
            st.builds(mavlink.MAVLink_timesync_message, integers, integers),
            st.builds(
                mavlink.MAVLink_heartbeat_message,
                *[st.integers(0, 255)] * 3,
                st.integers(0, (1 << 32) - 1),
                *[st.integers(0, 255)] * 2,
            ),
        )
    )
    return message.get_msgId(), system, component, message.pack(mav)


@given(st.lists(mavlink_frame()))
def test_frames_in_a_row_are_found_whole_and_in_order(sent: list[Frame]) -> None:
    assert list(frames(b"".join(f[3] for f in sent))) == sent


@given(st.lists(st.tuples(CLEAN, mavlink_frame())), CLEAN)
def test_no_frame_is_lost_in_garbage_without_a_magic_byte(
    sent: list[tuple[bytes, Frame]], tail: bytes
) -> None:
    found = list(frames(b"".join(g + f[3] for g, f in sent) + tail))
    at = -1
    for _, frame in sent:
        at = found.index(frame, at + 1)


@given(mavlink_frame(), st.integers(1, 30))
def test_a_cut_frame_is_not_yielded(frame: Frame, cut: int) -> None:
    assert frame not in list(frames(frame[3][:-cut]))


@given(mavlink_frame(), mavlink_frame(), st.binary(min_size=13, max_size=13))
def test_a_signed_frame_is_taken_with_its_signature(a: Frame, b: Frame, signature: bytes) -> None:
    signed = a[3][:2] + b"\x01" + a[3][3:] + signature
    assert list(frames(signed + b[3])) == [(*a[:3], signed), b]


@given(st.binary(max_size=600), mavlink_frame())
def test_garbage_yields_only_pieces_of_itself_and_hides_no_frame(
    garbage: bytes, last: Frame
) -> None:
    data = b"\0" + garbage + last[3]
    found = [frame for _, _, _, frame in frames(data)]
    assert last[3] in found
    assert all(frame in data and frame[0] == 0xFD for frame in found)


def test_a_frame_covered_by_a_false_header_is_found() -> None:
    frame = mavlink.MAVLink_heartbeat_message(11, 0, 1, 4, 4, 3).pack(mavlink.MAVLink(None, 2, 1))
    for length in (0, 5, 40):
        false_header = bytes([0xFD, length, 0, 0, 0, 0, 0, 0, 0, 0])
        found = list(frames(b"\x00" + false_header + frame + bytes(60)))
        assert (0, 2, 1, frame) in found
