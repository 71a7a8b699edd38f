# SPDX-License-Identifier: MIT
"""Real flotillad processes on a real bus, against the lockstep run of the same scenario."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from sil.cli.main import main
from sil.live.live_world import LiveWorld, buses_of
from sil.lockstep import metrics
from sil.lockstep.trace import Tracer
from sil.lockstep.world import Progress, Run
from sil.report import one_run
from sil.scenario import scenario
from sil.view.history import numbers
from sil.view.recorded import history_of_run
from tests.live_buses import live_buses
from tests.punctual import sail_punctually
from tests.turns import some

DURATION_S = 40
COASTING_RUN_S = 10


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short live run of `diamond` on mcast:1 … mcast:4."""

    def sail(out: Path) -> None:
        for name in (
            "recording.bin",
            "run.mcap",
            "boat2/flotillad.log",
            "boat2/log/mavlink0-00001.tlog",
            "boat2/state/parameters.txt",
        ):
            (out / name).parent.mkdir(parents=True, exist_ok=True)
            (out / name).write_bytes(b"of an earlier run")
        with live_buses() as bus:
            arguments = ["live", "diamond", "--bus", bus, "--duration", str(DURATION_S)]
            assert main([*arguments, "--out", str(out)]) == 0

    return sail_punctually(sail, tmp_path_factory.mktemp("live"))


def test_live_boats_are_where_the_lockstep_has_them(live: Path, diamond: tuple[Run, Path]) -> None:
    with np.load(live / "trace.npz") as trace:
        sailed = metrics.distances(trace["error"])
    expected = metrics.distances(diamond[0].trace["error"])
    for t_s in (20, DURATION_S):
        difference = np.abs(sailed[100 * t_s] - expected[100 * t_s])
        assert (difference < 0.05 + 0.1 * expected[100 * t_s]).all(), (t_s, difference)


def states_after_release(boat: dict[str, Any]) -> list[str]:
    """The reported states, without a HOLD in the first 0.5 s, which was sent before the release."""
    states = boat["states"]
    if len(states) > 1 and states[0][1] == "HOLD" and states[1][0] < 0.5:
        states = states[1:]
    return [state for _, state in states]


def test_a_live_run_leaves_all_that_a_lockstep_run_leaves_but_the_digest(live: Path) -> None:
    summary = json.loads((live / "summary.json").read_text(encoding="utf-8"))
    assert summary["digest"] is None
    assert [boat["states"].keys() for boat in summary["boats"]] == [{"FORMATION"}] * 4
    assert (live / "report.html").exists()


def test_a_live_run_is_played_back_with_its_boats_telemetry(live: Path) -> None:
    history = history_of_run(live)
    t_s = numbers(history["t_s"])
    for boat in some(history["vessels"][1:]):
        assert states_after_release(boat) == ["FORMATION"]
        assert set(numbers(boat["battery_V"])) == {24.0}
        assert (numbers(boat["leader_age_s"]) < 1.0).all()
        thrust, rpm = numbers(boat["thrust_port_N"]), numbers(boat["port_rpm"])
        turns = np.sign(thrust) * np.sqrt(np.abs(thrust))
        # values sent once a second are held: they match half a second late, not otherwise
        likeness = {
            late_s: np.corrcoef(np.interp(t_s - late_s, t_s, turns)[t_s > 5.0], rpm[t_s > 5.0])[
                0, 1
            ]
            for late_s in (-3.0, 0.5, 4.0)
        }
        assert likeness[0.5] == max(likeness.values()) > 0.9, likeness


class LeaderFallsSilent(LiveWorld):
    """A live world whose virtual leader falls silent after four seconds."""

    def run(self, program: Path, out: Path, progress: Progress) -> Tracer:
        def silencing(share: float) -> None:
            if share * COASTING_RUN_S > 3.5:  # reported once a second
                self._leader.outbox = []
            progress(share)

        return super().run(program, out, silencing)


def test_a_boat_that_coasts_in_a_live_run_coasts_in_the_replay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sil.live.live_world.LiveWorld", LeaderFallsSilent)
    diamond = scenario.load("diamond", [f"duration_s={COASTING_RUN_S}"])
    pair = diamond.model_copy(update={"boat": diamond.boat[:2]})
    parameters = {"FS_LEADER_S": 1.0, "FS_COAST_S": 60.0}
    words, summary = io.StringIO(), None

    def sail(out: Path) -> None:
        nonlocal words, summary
        words = io.StringIO()
        with live_buses() as bus:
            summary = one_run.live(pair, bus, out, parameters, "", Console(file=words))

    out = sail_punctually(sail, tmp_path)
    assert summary is not None
    behind_it, behind_boat_1 = (boat["states"] for boat in summary["boats"])
    assert behind_it.keys() == {"FORMATION", "COAST"}
    assert 3.0 < behind_it["COAST"] < 6.0
    assert behind_boat_1.keys() == {"FORMATION"}
    assert "boat 1 was " in words.getvalue()
    played_back = history_of_run(out)["vessels"][1:]
    assert states_after_release(played_back[0]) == ["FORMATION", "COAST"]
    assert states_after_release(played_back[1]) == ["FORMATION"]


def test_nothing_of_an_earlier_run_in_the_folder_is_taken_for_this_ones(live: Path) -> None:
    assert not (live / "recording.bin").exists()
    assert not (live / "run.mcap").exists()
    logs = sorted((live / "boat2" / "log").glob("*.tlog"))
    assert [log.name for log in logs] == [f"mavlink{link}-00001.tlog" for link in range(3)]
    assert not any(b"earlier" in log.read_bytes() for log in logs)
    for name in ("flotillad.log", "state/parameters.txt"):
        assert "earlier" not in (live / "boat2" / name).read_text(encoding="utf-8")


class BoatEnds(LiveWorld):
    """A live world in which boat 2's process is killed after two seconds."""

    def run(self, program: Path, out: Path, progress: Progress) -> Tracer:
        def killing(share: float) -> None:
            if share * COASTING_RUN_S > 1.5 and (process := self.boats[1].process) is not None:
                process.kill()
            progress(share)

        return super().run(program, out, killing)


def test_a_boat_whose_process_ends_under_way_ends_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sil.live.live_world.LiveWorld", BoatEnds)
    with live_buses() as bus:
        arguments = ["live", "diamond", "--bus", bus, "--duration", str(COASTING_RUN_S)]
        assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
    assert "error: boat 2: " in capsys.readouterr().err
    assert not (tmp_path / "out" / "summary.json").exists()


def test_a_refusal_by_flotillad_is_reported_in_its_own_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with live_buses() as bus:
        arguments = ["live", "diamond", "--bus", bus, "--param", "NOPE=1", "--out", str(tmp_path)]
        assert main(arguments) == 2
    assert "NOPE" in capsys.readouterr().err


def test_every_boat_left_its_latencies_and_kept_its_rate(live: Path) -> None:
    for boat in range(1, 5):
        stats = json.loads((live / f"boat{boat}" / "stats.json").read_text(encoding="utf-8"))
        assert stats["ticks"] > 95 * DURATION_S
        assert stats["can"]["transfers_dropped"] == stats["can"]["bad_packets"] == 0


def test_boat_i_takes_the_next_bus() -> None:
    assert buses_of("mcast:0", 3) == ["mcast:0", "mcast:1", "mcast:2"]
    assert buses_of("socketcan:vcan1", 2) == ["socketcan:vcan1", "socketcan:vcan2"]


@pytest.mark.parametrize("bus", ["", "mcast", "mcast:", "mcast:x", "vcan0", "socketcan:can", "x:0"])
def test_an_invalid_bus_is_refused(
    bus: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["live", "diamond", "--bus", bus, "--out", str(tmp_path)]) == 2
    assert "must be mcast:N or socketcan:NAMEn" in capsys.readouterr().err
