# SPDX-License-Identifier: MIT
"""Sending MAVLink to a multicast group or to one listener."""

import select
import socket

import pytest

from sil.live.free_port import free_port
from sil.wire.mavlink_mcast import LOOPBACK, Group, Mouth, group_of, host_and_port, listener

PATIENCE_S = 20.0


def heard(end: socket.socket) -> bytes:
    assert select.select([end], [], [], PATIENCE_S)[0]
    return end.recv(1000)


def test_all_listeners_of_the_group_receive_all_messages_in_order() -> None:
    group = Group("239.255.145.64", free_port())
    with listener(group) as one, listener(group) as other:
        mouth = Mouth(f"mcast:{group.host}:{group.port}")
        for data in (b"first", b"", b"second"):
            mouth.send(data, 0)
        for end in (one, other):
            assert [heard(end), heard(end)] == [b"first", b"second"]
        mouth.close()


def test_messages_on_the_loopback_do_not_leave_the_machine() -> None:
    mouth = Mouth(f"mcast:239.255.145.65:{free_port()}")
    hops = mouth._socket.getsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL)
    interface = mouth._socket.getsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, 4)
    assert hops == 0 and socket.inet_ntoa(interface) == LOOPBACK
    mouth.close()


def test_a_listener_that_was_gone_hears_again_when_it_is_back() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.bind((LOOPBACK, 0))
        place = end.getsockname()
        mouth = Mouth(f"udpout:{LOOPBACK}:{place[1]}")
        mouth.send(b"there", 0)
        assert heard(end) == b"there"
    for _ in range(5):
        mouth.send(b"gone", 0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.bind(place)
        mouth.send(b"lost", 0)  # not sent: the network reports the last refusal
        mouth.send(b"back", 0)
        assert heard(end) == b"back"
    mouth.close()


def test_addresses_are_read_as_they_are_written() -> None:
    assert group_of("") == Group("239.255.145.50", 14550, LOOPBACK)
    assert group_of("239.0.0.1:7") == Group("239.0.0.1", 7, LOOPBACK)
    assert group_of("239.0.0.1:7:10.0.0.1") == Group("239.0.0.1", 7, "10.0.0.1")
    assert host_and_port("[::1]:80") == ("::1", 80)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("1", "must be mcast:"),
        ("239.0.0.1", "must be mcast:"),
        ("239.0.0.1:7:x:y", "must be mcast:"),
        ("10.0.0.1:7", "10.0.0.1 is not a multicast group"),
        ("239.0.0.1:x", '"x" is not a port'),
        ("239.0.0.1:65536", '"65536" is not a port'),
        ("239.0.0.1:7:x", "'x'"),
    ],
)
def test_an_address_that_is_no_multicast_group_is_refused(text: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        group_of(text)


def test_a_datagram_that_the_network_refuses_does_not_keep_the_next_one_back() -> None:
    group = Group("239.255.145.66", free_port())
    with listener(group) as end:
        mouth = Mouth(f"mcast:{group.host}:{group.port}")
        mouth.send(bytes(70_000), 0)  # longer than a datagram
        mouth.send(b"next", 0)
        assert heard(end) == b"next"
        mouth.close()
