# SPDX-License-Identifier: MIT
"""Made-up campaigns: folders with files and plausible numbers, without sailing."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sil.plant.hull import Array

DURATION_S = 120
_MOST_RUNS = 100


@dataclass(frozen=True)
class Made:
    """A campaign: `draw` is the seed of the runs' starts, `gain` scales the law's residual error.

    Numbers are those of the paper's law in white noise: |e| about 0.35 m after 50 s.
    """

    runs: int = 40
    boats: int = 4
    draw: int = 1
    gain: float = 1.0
    diverged: tuple[int, ...] = ()
    failed: tuple[int, ...] = ()
    scenario: str = "made_up"

    def write(self, folder: Path, *, over_time: bool = True) -> Path:
        folder.mkdir(parents=True, exist_ok=True)
        rng = np.random.default_rng([5, self.draw])
        # of as many runs as there may be: a run does not depend on how many there are
        shape = (_MOST_RUNS, self.boats)
        start_m = rng.lognormal(1.8, 0.5, shape)[: self.runs]
        of_run, of_boat = rng.normal(0.0, 0.15, (_MOST_RUNS, 1)), rng.normal(0.0, 0.2, shape)
        level_m = self.gain * 0.4 * np.exp(of_run + of_boat)[: self.runs]
        separation_m = rng.uniform(0.05, 1.2, _MOST_RUNS)[: self.runs]
        self._header(folder)
        self._table(folder, level_m, separation_m, rng)
        if over_time:
            self._over_time(folder, start_m, level_m, rng)
        return folder

    def _outcome(self, run: int) -> str:
        return "failed" if run in self.failed else "diverged" if run in self.diverged else "ok"

    def _header(self, folder: Path) -> None:
        boats = [{"follows": i, "offset_m": [0.0, 0.0]} for i in range(self.boats)]
        header = {
            "scenario": self.scenario,
            "document": {"duration_s": DURATION_S, "boat": boats},
            "parameters": {},
            "code": "cd" * 32,
            "command": "flotilla campaign made_up",
            "seed": self.draw,
            "runs": self.runs,
            "versions": {"flotilla": "0.1"},
            "wall_s": 4.0,
            "boat_seconds_per_s": self.runs * self.boats * DURATION_S / 4.0,
            "digest": "ab" * 32,
        }
        (folder / "campaign.json").write_text(json.dumps(header))

    def _table(
        self, folder: Path, level_m: Array, separation_m: Array, rng: np.random.Generator
    ) -> None:
        rows = []
        settling_s = rng.uniform(40.0, 80.0, (_MOST_RUNS, self.boats))
        thrust_N = 5.5 * np.exp(rng.normal(0.0, 0.05, (_MOST_RUNS, self.boats)))
        for run, boat in np.ndindex(level_m.shape):
            outcome, m = self._outcome(run), float(level_m[run, boat])
            scale, thrust = (1e3, 10.0) if outcome == "diverged" else (1.0, 1.0)
            thrust *= float(thrust_N[run, boat])
            row = {
                "run": run,
                "seed": 1000 * self.draw + run,
                "boat": boat + 1,
                "outcome": outcome,
                "reason": "" if outcome == "ok" else f"boat {boat + 1} <{outcome}>",
                "digest": "" if outcome == "failed" else f"{self.draw}-{run}-{self.gain}",
            }
            numbers = {
                "rms_error_m": scale * m,
                "max_error_m": 2.0 * scale * m,
                "final_x_m": scale * m,
                "final_y_m": 0.0,
                "final_psi_rad": 0.1,
                "error_p50_m": 0.9 * scale * m,
                "error_p95_m": 1.6 * scale * m,
                "settling_time_s": None if m > 0.6 else float(settling_s[run, boat]),
                "thrust_rms_N": thrust,
                "thrust_step_rms_N": 0.3 * thrust,
                "min_separation_m": float(separation_m[run]) if self.boats > 1 else None,
                "s_FORMATION": float(DURATION_S) - run % 2,
                "s_HOLD": float(run % 2),
                "s_FAULT": 0.0,
            }
            lost = outcome == "failed"
            rows.append(row | {name: None if lost else x for name, x in numbers.items()})
        pq.write_table(pa.Table.from_pylist(rows), folder / "table.parquet")
        draws = [
            {"run": run, "key": "boat.1.eta.0", "value": float(separation_m[run])}
            for run in range(self.runs)
        ]
        pq.write_table(pa.Table.from_pylist(draws), folder / "draws.parquet")

    def _over_time(
        self, folder: Path, start_m: Array, level_m: Array, rng: np.random.Generator
    ) -> None:
        t_s = np.arange(DURATION_S + 1.0)
        walk = rng.normal(0.0, 0.4, (self.runs, self.boats, t_s.size))
        smooth = np.exp(np.apply_along_axis(np.convolve, 2, walk, np.ones(6) / 2.0, "same"))
        e_m = start_m[..., None] * np.exp(-t_s / 14.0) + level_m[..., None] * smooth
        e_m[list(self.diverged)] *= np.exp(t_s / 12.0)
        sailed = [run for run in range(self.runs) if run not in self.failed]
        run, boat, second = np.ix_(np.array(sailed), np.arange(1, self.boats + 1), t_s)
        shape = (len(sailed), self.boats, t_s.size)
        columns = {
            "run": np.broadcast_to(run, shape).ravel().astype(np.int32),
            "boat": np.broadcast_to(boat, shape).ravel().astype(np.int16),
            "t_s": np.broadcast_to(second, shape).ravel(),
            "error_m": e_m[sailed].ravel().astype(np.float32),
            "psi_rad": np.zeros(np.prod(shape), np.float32),
        }
        pq.write_table(pa.table(columns), folder / "seconds.parquet")
        e_m[list(self.diverged)] = np.inf
        if not sailed:
            t_s, e_m, sailed = t_s[:0], e_m[..., :0], [0]
        spread = np.percentile(e_m[sailed], (5, 25, 50, 75, 95), axis=0, method="inverted_cdf")
        boat, second = np.meshgrid(range(1, self.boats + 1), t_s, indexing="ij")
        envelopes = {"boat": boat.ravel().astype(np.int16), "t_s": second.ravel()}
        for name, values in zip(("p5", "p25", "p50", "p75", "p95"), spread, strict=True):
            envelopes[name] = values.ravel()
        envelopes["n"] = np.full(boat.size, len(sailed))
        envelopes["n_diverged"] = np.full(boat.size, len(self.diverged))
        pq.write_table(pa.table(envelopes), folder / "envelopes.parquet")
