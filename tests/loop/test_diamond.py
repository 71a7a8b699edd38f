# SPDX-License-Identifier: MIT
"""The paper's run against its continuous-time solution, and its repeatability."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sil.cli.main import main
from sil.lockstep import metrics
from sil.lockstep.recording import Recording
from sil.lockstep.replay import replay
from sil.lockstep.world import Run, World
from sil.report.figures import REFERENCE
from sil.scenario import scenario

ROOT = Path(__file__).parent.parent.parent
SHORT = "duration_s=10"


def test_every_boat_keeps_within_3_cm_of_the_continuous_solution(
    diamond: tuple[Run, Path],
) -> None:
    reference = np.genfromtxt(REFERENCE, delimiter=",", names=True)
    error = diamond[0].trace["error"][::100]
    assert len(error) == len(reference) == 301
    for boat in range(4):
        for axis, column in enumerate(("ex{}_m", "ey{}_m", "epsi{}_rad")):
            difference = error[:, boat, axis] - reference[column.format(boat + 1)]
            if axis == 2:
                difference = metrics.wrap(difference)
            assert np.abs(difference).max() < 0.03, (boat + 1, column)


def test_every_boat_is_within_half_a_millimetre_of_its_slot_from_200_s_on(
    diamond: tuple[Run, Path],
) -> None:
    late_m = metrics.distances(diamond[0].trace["error"])[20_000:].max(axis=0)
    assert (late_m < 0.0005).all(), late_m


def test_the_virtual_leader_sails_the_reference(diamond: tuple[Run, Path]) -> None:
    reference = np.genfromtxt(REFERENCE, delimiter=",", names=True)
    eta = diamond[0].trace["eta"][::100, 0]
    for axis, column in enumerate(("x0_m", "y0_m", "psi0_rad")):
        assert eta[:, axis] == pytest.approx(reference[column], abs=1e-6)


def test_the_trace_has_the_shapes_that_users_rely_on(diamond: tuple[Run, Path]) -> None:
    trace = diamond[0].trace
    shapes = {name: array.shape for name, array in trace.items()}
    ticks = 30_001
    assert shapes == {
        "t_s": (ticks,),
        "eta": (ticks, 5, 3),
        "nu": (ticks, 5, 3),
        "error": (ticks, 4, 3),
        "tau": (ticks, 4, 2),
        "thrust": (ticks, 4, 2),
    }
    assert trace["t_s"][[0, -1]] == pytest.approx([0.0, 300.0])
    # Held at the start until the tick at which FORMATION begins, driven from that tick on.
    assert trace["eta"][0, 1].tolist() == [1.46, 0.45, 1.33]
    assert np.abs(trace["thrust"][0]).min() > 0.0
    # Nowhere near the propellers' limit of 50 N: the paper has none.
    assert 12.0 < np.abs(trace["tau"]).max() < 14.0


def test_boats_spend_the_whole_run_in_formation(diamond: tuple[Run, Path]) -> None:
    assert diamond[0].states == [pytest.approx({"FORMATION": 300.01})] * 4


def test_boats_3_and_4_pass_within_1_2_m_of_each_other(diamond: tuple[Run, Path]) -> None:
    assert metrics.min_separation_m(diamond[0].trace["eta"]) == pytest.approx(1.18, abs=0.02)


def test_the_recording_replays_bit_for_bit(diamond: tuple[Run, Path]) -> None:
    run, path = diamond
    recording = Recording(path)
    assert recording.digest() == run.digest
    assert replay(recording) == [-1, -1, -1, -1]


def test_a_replay_with_another_gain_differs_at_the_first_driven_tick(tmp_path: Path) -> None:
    digest(tmp_path)
    assert main(["replay", str(tmp_path)]) == 0
    recording = Recording(tmp_path / "recording.bin")
    recording.header["boats"][1]["parameters"]["LAW_KX"] = 0.3
    first = replay(recording)
    assert first[0] == first[2] == first[3] == -1
    assert 1_000_000 < first[1] < 5_000_000


def digest(out: Path, *overrides: str, **parameters: float) -> str | None:
    chosen = scenario.load("diamond", [SHORT, *overrides])
    return World(chosen, parameters).run(out / "recording.bin", lambda _: None).digest


def test_the_same_seed_gives_the_same_digest_and_a_changed_gain_another(tmp_path: Path) -> None:
    once = digest(tmp_path)
    assert digest(tmp_path) == once
    assert digest(tmp_path, LAW_KX=0.21) != once
    assert digest(tmp_path, "navigation.position_noise_m=0.01") != once


def test_another_seed_is_another_run_only_where_something_is_random(tmp_path: Path) -> None:
    noisy = "navigation.position_noise_m=0.01"
    assert digest(tmp_path, noisy) == digest(tmp_path, noisy)
    assert digest(tmp_path, noisy) != digest(tmp_path, noisy, "seed=2")


def test_the_command_line_in_another_process_gives_the_same_digest(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "sil",
        "run",
        "diamond",
        "--set",
        SHORT,
        "--out",
        str(tmp_path),
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["digest"] == digest(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        "errors.png",
        "formation.png",
        "recording.bin",
        "report.html",
        "summary.json",
        "thrust.png",
        "trace.npz",
    }


def test_a_double_precision_boat_sails_the_same_course_within_a_fifth_of_a_millimetre(
    tmp_path: Path,
) -> None:
    error = {}
    for scalar in ("float", "double"):
        chosen = scenario.load("diamond", ["duration_s=40", f"scalar='{scalar}'"])
        error[scalar] = World(chosen, {}).run(tmp_path / "r.bin", lambda _: None).trace["error"]
    assert np.abs(error["float"] - error["double"]).max() < 0.0002


def test_in_fixed_point_every_boat_is_within_a_millimetre_of_double_at_every_tick(
    tmp_path: Path,
) -> None:
    place = {}
    for scalar in ("double", "q16"):
        chosen = scenario.load("diamond", [f"scalar='{scalar}'"])
        trace = World(chosen, {}).run(tmp_path / "r.bin", lambda _: None).trace
        place[scalar] = trace["eta"][:, :, :2]
        assert trace["t_s"][-1] >= 299.98
    apart = np.linalg.norm(place["q16"] - place["double"], axis=-1)
    assert apart.max() < 0.001
    assert apart.max() > 0  # it is another arithmetic
