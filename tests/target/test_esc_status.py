# SPDX-License-Identifier: MIT
"""When a boat considers its ESCs online."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.target.bus import esc_status, node_status
from tests.target.sea import Sea, at_sea


def test_escs_are_online_once_both_report_and_are_healthy(sea: Sea) -> None:
    assert not sea.condition("escs_online")
    sea.step()
    assert sea.condition("escs_online")


@pytest.mark.parametrize("silent", [[0], [1], [0, 1]], ids=["port", "stbd", "both"])
@pytest.mark.parametrize("limit", [0.3, 1.2, 2.5])
def test_an_esc_is_offline_fs_esc_s_after_its_last_status(silent: list[int], limit: float) -> None:
    sea = Sea({"FS_ESC_S": limit})
    sea.run(1.0)
    while sea.now_us % 100_000:
        sea.step()
    sea.step()  # both have just said their status
    last_us = sea.ticks[-1].now_us
    for k in silent:
        sea.escs[k].on = False
    for _ in range(600):
        if (sea.now_us - last_us) % 500_000 == 0:
            for k in silent:  # its node lives on, only its status is missing
                transfer_id = sea.now_us // 500_000 % 32
                sea.on_can(node_status(sea.escs[k].node, sea.now_us // 10**6, transfer_id))
        sea.step()
        age = (sea.ticks[-1].now_us - last_us) * 1e-6
        if age < limit - 0.011:
            assert sea.condition("escs_online"), age
        if age > limit + 0.011:
            assert not sea.condition("escs_online"), age


def test_an_esc_is_offline_three_seconds_after_its_last_node_status(sea: Sea) -> None:
    sea.run(1.5)
    sea.escs[1].next_beat_us = 2**62
    for _ in range(200):
        sea.step()
        assert sea.condition("escs_online")
    sea.run(1.02)
    assert not sea.condition("escs_online")
    sea.escs[1].next_beat_us = 0
    sea.run(0.02)
    assert sea.condition("escs_online")


@pytest.mark.parametrize("health", [1, 2, 3])
@pytest.mark.parametrize("which", [0, 1])
def test_an_esc_whose_node_is_not_healthy_is_not_online(sea: Sea, health: int, which: int) -> None:
    sea.escs[which].health = health
    sea.run(1.5)
    assert not sea.condition("escs_online")
    sea.escs[which].health = 0
    sea.run(1.1)
    assert sea.condition("escs_online")


def test_an_esc_that_becomes_unhealthy_under_way_causes_a_fault() -> None:
    sea = at_sea()
    sea.escs[0].health = 2
    sea.run(1.1)
    assert sea.state == "FAULT" and sea.commands == (0, 0)


def test_other_escs_and_other_nodes_do_not_count(sea: Sea) -> None:
    for esc in sea.escs:
        esc.index += 2
    sea.run(2.0)
    assert not sea.condition("escs_online")
    sea.on_can(esc_status(31, 0))
    sea.on_can(esc_status(32, 1))
    sea.step()
    assert sea.condition("escs_online")


def test_one_node_may_drive_both_propellers(sea: Sea) -> None:
    sea.escs[0].on = sea.escs[1].on = False
    for k in range(30):
        sea.on_can(esc_status(40, 0, 2 * k % 32) + esc_status(40, 1, (2 * k + 1) % 32))
        sea.on_can(node_status(40, k, k % 32))
        sea.run(0.1)
    assert sea.condition("escs_online")


def test_the_frames_of_two_escs_may_interleave(sea: Sea) -> None:
    sea.escs[0].on = sea.escs[1].on = False
    port, stbd = esc_status(31, 0), esc_status(32, 1)
    sea.on_can(node_status(31, 1) + node_status(32, 1))
    sea.on_can([frame for pair in zip(port, stbd, strict=True) for frame in pair])
    sea.step()
    assert sea.condition("escs_online") and sea.refused("can") == 0


@pytest.mark.parametrize(
    "changes",
    [
        {"voltage": v, "current": v, "temperature": v}
        for v in (math.nan, math.inf, -math.inf, 65504.0)
    ],
    ids=str,
)
def test_an_esc_that_measures_no_voltage_or_current_is_online(
    sea: Sea, changes: dict[str, Any]
) -> None:
    sea.escs[0].on = sea.escs[1].on = False
    sea.on_can(node_status(31, 1) + node_status(32, 1))
    sea.on_can(esc_status(31, 0, **changes) + esc_status(32, 1, rpm=-131072, error_count=2**32 - 1))
    sea.step()
    assert sea.condition("escs_online")
