# SPDX-License-Identifier: MIT
"""Rerun's own converter finds the boats on the map and in space; `tools/test` installs it."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from sil.cli.main import main
from sil.logs.run_folder import NAME
from sil.scenario.wiring import WORLD

ROOT = Path(__file__).parents[3]
SAMPLES = 21

pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def rerun() -> Path:
    """The program in the package."""
    program = ROOT / "build" / "rerun" / "rerun_cli" / "rerun"
    if not program.exists():
        pytest.skip(f"no {program}, nothing was tried with Rerun: see tools/test")
    return program


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two seconds of four boats."""
    out = tmp_path_factory.mktemp("run")
    assert main(["run", "diamond", "--set", "duration_s=2", "--mcap", "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def rrd(rerun: Path, folder: Path) -> Path:
    """The folder's MCAP file converted by Rerun."""
    out = folder / "run.rrd"
    subprocess.run([rerun, "mcap", "convert", folder / NAME, "-o", out], check=True)
    return out


def chunks(rerun: Path, rrd: Path, entity: str, *options: str) -> str:
    command = [str(rerun), "rrd", "print", *options, "--entity", entity, str(rrd)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def rows(printed: str, component: str) -> int:
    """The number of rows of the chunks that contain a component."""
    found = re.findall(r"with (\d+) rows .* - data columns: \[(.*)\]", printed)
    return sum(int(count) for count, columns in found if component in columns)


def test_rerun_finds_nothing_wrong_with_the_file(rerun: Path, folder: Path) -> None:
    subprocess.run([rerun, "mcap", "check", folder / NAME], check=True)


def test_every_fix_is_a_point_on_the_map(rerun: Path, rrd: Path, folder: Path) -> None:
    with np.load(folder / "trace.npz") as file:
        eta = file["eta"]
    for agent, name in enumerate(("leader100", "boat1", "boat2", "boat3", "boat4")):
        assert rows(chunks(rerun, rrd, f"/{name}/fix", "-v"), "GeoPoints:positions") == SAMPLES
        printed = chunks(rerun, rrd, f"/{name}/fix", "-vvv")
        points = re.findall(r"\[\[(\d+\.\d+), (\d+\.\d+)\]\]", printed)
        expected = [WORLD.geodetic(*pose[agent].tolist())[:2] for pose in eta[::10]]
        assert [(round(1e7 * float(n)), round(1e7 * float(e))) for n, e in points] == expected


def test_every_pose_and_slot_is_a_transform(rerun: Path, rrd: Path) -> None:
    printed = chunks(rerun, rrd, "/tf", "-v")
    assert rows(printed, "Transform3D:translation") == 9 * SAMPLES
    assert "Transform3D:child_frame" in printed and "Transform3D:quaternion" in printed


def test_the_log_and_our_own_messages_are_read_too(rerun: Path, rrd: Path) -> None:
    assert rows(chunks(rerun, rrd, "/boat2/log", "-v"), "TextLog:text") >= 3
    assert rows(chunks(rerun, rrd, "/boat2/state", "-v"), "flotilla.State:message") == SAMPLES
