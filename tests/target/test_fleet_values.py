# SPDX-License-Identifier: MIT
"""A fleet refuses wrong arguments and names the right ones."""

from __future__ import annotations

from typing import Any

import flotilla
import numpy as np
import pytest

LOCAL, EXACT = (100.0, "local", 0.0), (0, 0.0)
GLOBAL = (100.0, "global", 0.0)


def fleet(unit: Any = LOCAL, **options: Any) -> Any:
    """A leader and two boats behind it."""
    made = flotilla.Fleet(**options)
    made.add_leader(0, 100, unit, EXACT)
    for system in (1, 2):
        made.add_boat(0, {"MAV_SYSID": system}, unit, EXACT)
        made.connect(0, system)
    return made


def arrays() -> dict[str, Any]:
    return {
        "eta": np.zeros((3, 3)),
        "nu": np.zeros((3, 3)),
        "degE7": np.zeros((3, 2), np.int32),
        "rpm": np.zeros((2, 2)),
        "command": np.zeros((2, 2)),
    }


BAD_ARRAYS = [
    ("eta", np.zeros((2, 3)), ValueError, r"eta: .* float64 array of shape \(3, 3\), not \(2, 3\)"),
    ("eta", np.zeros(9), ValueError, r"eta: .*\(3, 3\), not \(9\)"),
    ("nu", np.zeros((3, 3, 1)), ValueError, r"nu: .*\(3, 3\), not \(3, 3, 1\)"),
    ("nu", np.zeros((3, 3), np.float32), TypeError, r"nu: a C-contiguous float64 array"),
    ("eta", np.zeros((3, 3), order="F"), TypeError, r"eta: a C-contiguous float64 array"),
    ("eta", np.zeros((6, 3))[::2], TypeError, r"eta: a C-contiguous float64 array"),
    ("eta", [[0.0] * 3] * 3, TypeError, r"eta: a C-contiguous float64 array"),
    ("degE7", np.zeros((3, 2)), TypeError, r"degE7: a C-contiguous int32 array of shape \(3, 2\)"),
    ("degE7", np.zeros((2, 2), np.int32), ValueError, r"degE7: .*\(3, 2\), not \(2, 2\)"),
    ("rpm", np.zeros((3, 2)), ValueError, r"rpm: .*\(2, 2\), not \(3, 2\)"),
    ("rpm", np.zeros((2, 2), int), TypeError, r"rpm: a C-contiguous float64 array"),
    ("command", np.zeros((2, 3)), ValueError, r"command: .*writable .*\(2, 2\), not \(2, 3\)"),
    ("command", np.broadcast_to(0.0, (2, 2)), TypeError, r"command: .*writable float64 array"),
]


@pytest.mark.parametrize(("name", "array", "error", "text"), BAD_ARRAYS)
def test_an_array_that_does_not_fit_is_refused(
    name: str, array: Any, error: type, text: str
) -> None:
    made = fleet()
    with pytest.raises(error, match=text):
        made.tick(0, **{**arrays(), name: array})
    made.tick(0, **arrays())


def test_sensed_values_may_be_read_only_arrays() -> None:
    told = arrays()
    for name in ("eta", "nu", "degE7", "rpm"):
        told[name].flags.writeable = False
    fleet(GLOBAL).tick(0, **told)


def test_a_unit_that_reports_degrees_requires_the_degE7_argument() -> None:
    with pytest.raises(ValueError, match=r"degE7: an int32 array of shape \(3, 2\)"):
        fleet(GLOBAL).tick(0, **{**arrays(), "degE7": None})


BAD_CALLS = [
    ("add_boat", (0, {"NO_SUCH": 1}, LOCAL, EXACT), "unknown parameter NO_SUCH"),
    ("add_boat", (0, {"MAV_SYSID": 0}, LOCAL, EXACT), "MAV_SYSID = 0 is out of range"),
    ("add_boat", (-1, {}, LOCAL, EXACT), "run: from 0"),
    ("add_leader", (0, 0, LOCAL, EXACT), "system: from 1 to 255"),
    ("add_leader", (0, 1, (0.0, "local", 0.0), EXACT), "unit: rate_hz"),
    ("add_leader", (0, 1, (float("nan"), "local", 0.0), EXACT), "unit: rate_hz"),
    ("add_leader", (0, 1, (1.0, "local", -1.0), EXACT), "unit: attitude_rate_hz"),
    ("add_leader", (0, 1, (1.0, "loud", 0.0), EXACT), 'unit: message is .*not "loud"'),
    ("add_leader", (0, 1, (*LOCAL, (910_000_000, 0, 0)), EXACT), "unit: origin"),
    ("add_leader", (0, 1, LOCAL, (-1, 0.0)), "clock: offset_us"),
    ("add_leader", (0, 1, LOCAL, (0, float("inf"))), "clock: drift_ppm"),
    ("connect", (0, 3), "agent 3: there are 3"),
    ("connect", (0, 1, -0.1), "delay_s: from 0"),
    ("connect", (0, 1, 0.0, float("nan")), "jitter_s: from 0"),
    ("connect", (0, 1, 0.0, 0.0, 1.1), "loss: from 0 to 1"),
    ("connect", (0, 1, 0.0, 0.0, 0.0, -5.0), "rate_Bps: 0 or from 1"),
    ("set_link", (2, 0.0, 0.0, 0.0, 0.0), "link 2: there are 2"),
    ("set_link", (0, 0.0, 0.0, -1.0, 0.0), "loss: from 0 to 1"),
    ("corrupt", (9, 0), "link 9: there are 2"),
    ("hear", (0, b"", 0), "agent 0 is a leader"),
    ("hear", (1, b"", 0, 2), r"link: 0 \(navigation unit\) or 1 \(radio\)"),
    ("hear", (1, b"", -1), "t_us: from 0"),
    ("on_can", (0, 1, b"", 0), "agent 0 is a leader"),
    ("command", ([0], 0, 400, (1.0,)), "agent 0 is a leader"),
    ("command", ([1], 0, 70_000, ()), "command: from 0 to 65535"),
    ("command", ([1], 0, 400, (0.0,) * 8), "params: at most 7 numbers"),
    ("snapshot", (0,), "agent 0 is a leader"),
    ("sent", (3,), "agent 3: there are 3"),
    ("take_records", (1,), "run 1: it has no agent"),
]


@pytest.mark.parametrize(("method", "arguments", "text"), BAD_CALLS)
def test_an_impossible_value_is_refused(method: str, arguments: Any, text: str) -> None:
    made = fleet(record=True)
    with pytest.raises(ValueError, match=text):
        getattr(made, method)(*arguments)
    made.tick(0, **arrays())


@pytest.mark.parametrize("unit", [(), (1.0, "local"), ("1", "local", 0.0), (*LOCAL, (1, 2)), 5])
def test_an_invalid_unit_is_refused(unit: Any) -> None:
    with pytest.raises(TypeError):
        flotilla.Fleet().add_leader(0, 1, unit, EXACT)


def test_an_unknown_scalar_of_a_fleet_is_refused() -> None:
    with pytest.raises(ValueError, match='scalar: "float", "double" or "q16", not "half"'):
        flotilla.Fleet("half")


def test_taking_records_needs_record_true() -> None:
    with pytest.raises(ValueError, match="record=True"):
        fleet().take_records(0)


def test_a_recording_has_room_for_256_agents() -> None:
    made, quiet = flotilla.Fleet(record=True), flotilla.Fleet()
    for _ in range(256):
        made.add_leader(3, 1, LOCAL, EXACT)
        quiet.add_leader(3, 1, LOCAL, EXACT)
    with pytest.raises(ValueError, match="256 agents"):
        made.add_leader(3, 1, LOCAL, EXACT)
    assert quiet.add_leader(3, 1, LOCAL, EXACT) == 256
    assert made.add_leader(4, 1, LOCAL, EXACT) == 256


def test_an_empty_fleet_has_nothing_to_do() -> None:
    made = flotilla.Fleet()
    made.tick(0, np.zeros((0, 3)), np.zeros((0, 3)), None, np.zeros((0, 2)), np.zeros((0, 2)))
    assert made.states.tolist() == []
