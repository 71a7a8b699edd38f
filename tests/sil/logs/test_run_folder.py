# SPDX-License-Identifier: MIT
"""A run's MCAP file agrees with the run."""

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sil.cli.main import main
from sil.cli.main import main as flotilla
from sil.logs.run_folder import EPOCH_S, NAME
from sil.plant.hull import Array
from sil.scenario.wiring import WORLD
from sil.wire.geodesy import LocalFrame
from tests.sil.logs.reading import assert_schemas_are_by_topic, messages_of, schemas_of
from tests.sil.mistakes import assert_told_in_one_line
from tests.turns import some

Topics = dict[str, list[tuple[int, Any]]]
SECONDS = 12.0
SAILED = ["run", "turning", "--set", f"duration_s={SECONDS}"]
LOST = ["--set", "fault=[{kind='radio_silent', agent=0, at_s=4.0, for_s=3.0}]"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run whose leader cannot be heard from 4 s to 7 s."""
    out = tmp_path_factory.mktemp("runs") / "run"
    assert main([*SAILED, *LOST, "--mcap", "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def trace(folder: Path) -> dict[str, Array]:
    with np.load(folder / "trace.npz") as file:
        return dict(file)


@pytest.fixture(scope="module")
def topics(folder: Path) -> Topics:
    return messages_of(folder / NAME)


def seconds(t_ns: int) -> float:
    return t_ns * 1e-9 - EPOCH_S


def test_every_boat_has_its_topics_in_foxgloves_schemas_and_ours(folder: Path) -> None:
    assert_schemas_are_by_topic(folder / NAME)
    topics = set(schemas_of(folder / NAME))
    kinds = ("fix", "scene", "state", "law", "status", "log", "esc/0", "esc/1")
    boats = {f"/boat{i}/{kind}" for i in (1, 2, 3, 4) for kind in kinds}
    assert topics == boats | {f"/leader100/{kind}" for kind in ("fix", "scene", "state")} | {"/tf"}


def test_states_errors_and_thrusts_are_those_of_the_trace(
    trace: dict[str, Array], topics: Topics
) -> None:
    for i in (1, 2, 3, 4):
        states, laws = topics[f"/boat{i}/state"], topics[f"/boat{i}/law"]
        assert len(states) == len(laws) == 121
        for (t_ns, state), (law_ns, law) in zip(states, laws, strict=True):
            k = round(100.0 * seconds(t_ns))
            assert t_ns == law_ns == EPOCH_S * 10**9 + k * 10**7
            pose = (state.x_m, state.y_m, state.psi_rad, state.u_mps, state.v_mps, state.r_radps)
            assert pose == (*trace["eta"][k, i], *trace["nu"][k, i])
            assert (law.error_x_m, law.error_y_m, law.error_psi_rad) == tuple(
                trace["error"][k, i - 1]
            )
            assert (law.thrust_port_N, law.thrust_stbd_N) == tuple(trace["thrust"][k, i - 1])


def test_fixes_are_the_poses_on_the_globe_to_a_centimetre(
    trace: dict[str, Array], topics: Topics
) -> None:
    for agent, name in enumerate(("leader100", "boat1", "boat2", "boat3", "boat4")):
        for t_ns, fix in some(topics[f"/{name}/fix"]):
            eta = trace["eta"][round(100.0 * seconds(t_ns)), agent]
            place = LocalFrame(round(fix.latitude * 1e7), round(fix.longitude * 1e7), 40.0)
            assert place.seen_from(WORLD, 0.0, 0.0, 0.0)[:2] == pytest.approx(eta[:2], abs=0.01)
            assert (fix.frame_id, fix.timestamp.ToNanoseconds()) == (name, t_ns)


def test_transforms_have_east_north_up_and_the_bow_ahead(
    trace: dict[str, Array], topics: Topics
) -> None:
    slots = 0
    for t_ns, message in topics["/tf"]:
        (transform,) = message.transforms
        assert transform.parent_frame_id == "world"
        k = round(100.0 * seconds(t_ns))
        x, y, psi = trace["eta"][k, int(transform.child_frame_id.split("/")[0][-1])]
        if transform.child_frame_id == "boat1/slot":  # at the virtual leader itself
            x, y, _ = trace["eta"][k, 0]
            slots += 1
        elif "/" in transform.child_frame_id or transform.child_frame_id == "leader100":
            continue
        else:
            q = transform.rotation
            ahead = 1.0 - 2.0 * q.z**2, 2.0 * q.z * q.w
            assert ahead == pytest.approx((math.sin(psi), math.cos(psi)))
        place = transform.translation
        assert (place.x, place.y, place.z) == pytest.approx((y, x, 0.0), abs=1e-9)
    assert slots == 121


def test_the_log_has_the_loss_and_the_return_of_a_leader(folder: Path, topics: Topics) -> None:
    lines = topics["/boat1/log"]
    assert {line.name for _, line in lines} == {"boat1"}
    changes = {line.message: seconds(t_ns) for t_ns, line in lines if "→" in line.message}
    assert changes["HOLD → FORMATION"] == pytest.approx(0.0, abs=0.02)
    assert 4.0 < changes["FORMATION → COAST"] < 6.0
    coasts = next(line for _, line in lines if line.message == "FORMATION → COAST")
    assert coasts.level == coasts.WARNING
    spent = json.loads((folder / "summary.json").read_text())["boats"][0]["states"]
    ended = min(t for message, t in changes.items() if message.startswith("COAST → "))
    assert ended - changes["FORMATION → COAST"] == pytest.approx(spent["COAST"], abs=0.02)


def test_escs_and_ages_are_those_sent_on_the_wires(topics: Topics) -> None:
    for index in (0, 1):
        escs = topics[f"/boat2/esc/{index}"]
        assert len(escs) >= 25 * SECONDS
        assert {esc.voltage_V for _, esc in escs} == {24.0}
        assert all(math.isnan(esc.temperature_degC) for _, esc in escs)
    ages = [law.leader_age_s for t_ns, law in topics["/boat1/law"] if 5.5 < seconds(t_ns) < 6.5]
    assert max(ages) > 1.0
    late = [law for t_ns, law in topics["/boat1/law"] if seconds(t_ns) > 10.0]
    assert max(law.leader_age_s for law in late) < 0.1
    assert {status.state for _, status in topics["/boat1/status"]} >= {"FORMATION", "COAST"}


def test_without_a_recording_only_topics_of_the_truth_are_written(
    folder: Path, tmp_path: Path
) -> None:
    shutil.copy(folder / "trace.npz", tmp_path)
    assert flotilla(["convert", str(tmp_path), "--out", str(tmp_path / "out.mcap")]) == 0
    kinds = {topic.rpartition("/")[2] for topic in schemas_of(tmp_path / "out.mcap")}
    assert kinds == {"fix", "scene", "state", "law", "tf"}


def test_converting_the_folder_again_gives_as_many_messages_of_each_topic(
    folder: Path, topics: Topics, tmp_path: Path
) -> None:
    out = tmp_path / "again.mcap"
    assert flotilla(["convert", str(folder), "--out", str(out)]) == 0
    assert {topic: len(said) for topic, said in messages_of(out).items()} == {
        topic: len(said) for topic, said in topics.items()
    }


@pytest.mark.parametrize("name", ["trace.npz", "recording.bin", "boat1/log/x.tlog"])
def test_converting_replaces_no_other_file_of_the_run(
    name: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = shutil.copytree(folder, tmp_path / "run")
    (run / "boat1" / "log").mkdir(parents=True)
    (run / "boat1" / "log" / "x.tlog").write_bytes(b"of a live run")
    before = (run / name).read_bytes()
    assert flotilla(["convert", str(run), "--out", str(run / name)]) == 2
    assert_told_in_one_line("is a file of the run to convert: choose another --out", capsys)
    assert (run / name).read_bytes() == before


def test_a_folder_without_a_recording_cannot_be_replayed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert flotilla(["replay", str(tmp_path)]) == 2
    assert_told_in_one_line(f"{tmp_path} has no recording: only flotilla run leaves one", capsys)


def test_a_run_without_mcap_removes_that_of_an_earlier_one(tmp_path: Path) -> None:
    (tmp_path / NAME).write_bytes(b"old")
    assert main(["run", "turning", "--set", "duration_s=1", "--out", str(tmp_path)]) == 0
    assert not (tmp_path / NAME).exists()


@pytest.mark.parametrize("name", ["trace.npz", "recording.bin", "summary.json"])
def test_a_damaged_run_is_reported_and_leaves_nothing(
    name: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = sorted({"trace.npz", "recording.bin", name})
    for file in kept:
        shutil.copy(folder / file, tmp_path)
    content = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(content[: len(content) // 2])
    assert flotilla(["convert", str(tmp_path)]) == 2
    assert_told_in_one_line(name, capsys)
    assert sorted(path.name for path in tmp_path.iterdir()) == kept


def test_a_live_runs_log_ignores_an_earlier_runs_recording(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path / "live")
    summary = json.loads((folder / "summary.json").read_text())
    (tmp_path / "live" / "summary.json").write_text(json.dumps({**summary, "digest": None}))
    assert flotilla(["convert", str(tmp_path / "live")]) == 0
    assert not any(
        topic.endswith("/status") for topic in some(messages_of(tmp_path / "live" / NAME))
    )


def test_a_recording_without_its_folder_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert flotilla(["convert", str(folder / "recording.bin")]) == 2
    assert_told_in_one_line("convert its folder", capsys)
