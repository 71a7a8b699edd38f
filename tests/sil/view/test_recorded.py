# SPDX-License-Identifier: MIT
"""Histories of runs: the truth from the trace, the boats' messages from the recording."""

import gc
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from sil.report.one_run import run
from sil.scenario import scenario
from sil.view.history import MOST_SAMPLES, most_samples, numbers
from sil.view.recorded import history_of, history_of_run
from tests.turns import some

LOST = """\
base = "diamond"
duration_s = 20.0
[[fault]]
kind = "radio_silent"
agent = 0
at_s = 6.0
"""


@pytest.fixture(scope="module")
def lost(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run whose virtual leader falls silent after 6 s."""
    folder = tmp_path_factory.mktemp("lost")
    path = folder / "lost.toml"
    path.write_text(LOST)
    run(scenario.load(path), folder / "run", {}, "again", Console(quiet=True))
    return folder / "run"


def by_id(history: dict[str, Any]) -> dict[int, dict[str, Any]]:
    return {vessel["id"]: vessel for vessel in history["vessels"]}


def test_a_history_has_the_truth_of_the_trace(lost: Path) -> None:
    history = history_of_run(lost)
    with np.load(lost / "trace.npz") as arrays:
        trace = dict(arrays)
    t_s, vessels = numbers(history["t_s"]), by_id(history)
    assert list(vessels) == [100, 1, 2, 3, 4] and t_s.size == MOST_SAMPLES
    assert (t_s[0], t_s[-1]) == pytest.approx((trace["t_s"][0], trace["t_s"][-1]))
    kept = np.searchsorted(trace["t_s"], t_s - 1e-4)
    for agent, vessel in enumerate(history["vessels"]):
        x_m, y_m = numbers(vessel["x_m"]), numbers(vessel["y_m"])
        np.testing.assert_allclose(x_m, trace["eta"][kept, agent, 0], atol=1e-4)
        np.testing.assert_allclose(numbers(vessel["u_mps"]), trace["nu"][kept, agent, 0], atol=1e-5)
        columns = some(text for text in vessel.values() if is_column(text))
        assert {len(numbers(text)) for text in columns} == {t_s.size}
        if agent:
            away = np.hypot(numbers(vessel["slot_x_m"]) - x_m, numbers(vessel["slot_y_m"]) - y_m)
            np.testing.assert_allclose(away, numbers(vessel["error_m"]), atol=1e-4)
            thrust = trace["thrust"][kept, agent - 1, 1]
            np.testing.assert_allclose(numbers(vessel["thrust_stbd_N"]), thrust, rtol=1e-5)


def is_column(value: Any) -> bool:
    return isinstance(value, str) and len(value) > 20


def test_slots_are_where_the_scenario_puts_them(lost: Path) -> None:
    vessels = by_id(history_of_run(lost))
    sailed = scenario.load("diamond")
    for number, boat in enumerate(sailed.boat, start=1):
        leader, own = vessels[vessels[number]["leader"]], vessels[number]
        for axis, name in enumerate(("x_m", "y_m")):
            offset = numbers(own[f"slot_{name}"]) - numbers(leader[name])
            np.testing.assert_allclose(offset, boat.offset_m[axis], atol=1e-4)
    assert vessels[1]["leader"] == 100 and vessels[1]["limits_N"] == [-50.0, 50.0]


def test_a_history_has_the_boats_telemetry_from_the_release_on(lost: Path) -> None:
    vessel = by_id(history_of_run(lost))[1]
    states = [state for _, state in vessel["states"]]
    assert states == ["FORMATION", "COAST", "HOLD"]
    coast_s, hold_s = vessel["states"][1][0], vessel["states"][2][0]
    assert vessel["states"][0][0] == 0.0
    assert 6.5 < coast_s < 8.0 and coast_s + 4.0 < hold_s < coast_s + 6.0
    held = [sentences for t_s, sentences in vessel["held"] if t_s > coast_s]
    assert "leader lost or origin unknown" in held[0]
    assert any("leader lost or origin unknown" in text for _, text in vessel["texts"])
    ages = numbers(vessel["leader_age_s"])
    assert ages[-1] > 10.0 and numbers(vessel["battery_V"])[-1] == 24.0


def test_a_history_has_the_escs_telemetry(lost: Path) -> None:
    history = history_of_run(lost)
    for boat in some(history["vessels"][1:]):
        for side in ("port", "stbd"):
            assert set(numbers(boat[f"{side}_voltage_V"])) == {24.0}
            assert set(numbers(boat[f"{side}_errors"])) == {0.0}
            rpm, thrust = numbers(boat[f"{side}_rpm"]), numbers(boat[f"thrust_{side}_N"])
            turns = np.sign(thrust) * np.sqrt(np.abs(thrust))
            # told once a second, of the second before
            likeness = [
                np.corrcoef(np.roll(turns, late)[120:], rpm[120:])[0, 1] for late in range(60)
            ]
            assert max(likeness) > 0.97 and np.abs(rpm).max() > 100
    assert not [name for name in history["vessels"][0] if name.endswith("rpm")]


def test_a_leader_that_was_heard_to_the_end_leaves_its_boats_in_formation(lost: Path) -> None:
    vessels = by_id(history_of_run(lost))
    assert vessels[100]["states"] == [] and vessels[100]["kind"] == "leader"


def test_the_recording_of_another_run_is_not_that_of_a_live_one(lost: Path, tmp_path: Path) -> None:
    shutil.copytree(lost, tmp_path / "live")
    summary = json.loads((lost / "summary.json").read_text())
    (tmp_path / "live" / "summary.json").write_text(
        json.dumps({**summary, "scenario": "diamond", "digest": None})
    )
    vessels = by_id(history_of_run(tmp_path / "live"))
    assert vessels[1]["states"] == [] and vessels[2]["leader"] == 1
    assert vessels[1]["limits_N"] == [-50.0, 50.0]


@pytest.mark.parametrize("damage", ["nothing", "summary.json", "trace.npz", "recording.bin"])
def test_a_folder_without_a_run_is_reported_in_one_line(
    damage: str, lost: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    if damage == "nothing":
        folder.mkdir()
    else:
        shutil.copytree(lost, folder)
        (folder / damage).write_bytes(b"damaged")
    with pytest.raises(ValueError, match=str(folder)) as told:
        history_of_run(folder)
    for unclear in ("\n", "Errno", "pickle"):
        assert unclear not in str(told.value)


def test_an_empty_trace_is_reported(lost: Path, tmp_path: Path) -> None:
    shutil.copytree(lost, tmp_path / "run")
    (tmp_path / "run" / "trace.npz").write_bytes(b"")
    with pytest.raises(ValueError, match=r"trace\.npz is damaged: sail the run again"):
        history_of_run(tmp_path / "run")


def test_a_trace_that_was_cut_off_is_refused_and_closed(lost: Path, tmp_path: Path) -> None:
    shutil.copytree(lost, tmp_path / "run")
    trace = tmp_path / "run" / "trace.npz"
    trace.write_bytes(trace.read_bytes()[:200])
    with pytest.raises(ValueError, match=r"trace\.npz is damaged: sail the run again"):
        history_of_run(tmp_path / "run")
    gc.collect()  # would warn of an open file


def test_a_recording_that_was_cut_off_has_no_times_and_is_refused(
    lost: Path, tmp_path: Path
) -> None:
    shutil.copytree(lost, tmp_path / "run")
    content = (lost / "recording.bin").read_bytes()
    (tmp_path / "run" / "recording.bin").write_bytes(content[: len(content) // 2])
    with pytest.raises(
        ValueError, match=r"recording.bin: damaged, or not the recording of the run"
    ):
        history_of_run(tmp_path / "run")


def test_a_trace_without_a_tick_is_no_run(lost: Path, tmp_path: Path) -> None:
    shutil.copytree(lost, tmp_path / "run")
    with np.load(lost / "trace.npz") as arrays:
        np.savez(tmp_path / "run" / "trace.npz", **{name: a[:0] for name, a in arrays.items()})
    with pytest.raises(ValueError, match=r"trace\.npz is empty"):
        history_of_run(tmp_path / "run")


def test_a_run_whose_scenario_is_not_known_has_boats_by_their_numbers(lost: Path) -> None:
    with np.load(lost / "trace.npz") as arrays:
        trace = dict(arrays)
    vessels = by_id(history_of("unknown", trace, None, None, 2.5))
    assert list(vessels) == [100, 1, 2, 3, 4]
    assert vessels[1]["leader"] is None and vessels[1]["length_m"] == 2.5


def test_a_thousand_boats_have_fewer_samples() -> None:
    assert most_samples(5) == MOST_SAMPLES and most_samples(1001) * 1001 <= 101_000
