# SPDX-License-Identifier: MIT
"""The tables of a campaign, from the results of its runs in any order."""

import hashlib
import json
from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sil.campaign.run_outcome import RunResult, distances
from sil.campaign.sampling import Sampler
from sil.plant.hull import Array

PERCENTILES = (5, 25, 50, 75, 95)
_FIGURES = (
    "rms_error_m",
    "max_error_m",
    "final_x_m",
    "final_y_m",
    "final_psi_rad",
    "error_p50_m",
    "error_p95_m",
    "settling_time_s",
    "thrust_rms_N",
    "thrust_step_rms_N",
)


def table(results: Sequence[RunResult], boats: int, states: Sequence[str]) -> pa.Table:
    """One row for each run and boat; figures are null if the run failed."""
    rows = []
    for result in results:
        of_run = {
            "run": result.run,
            "seed": result.seed,
            "outcome": result.outcome,
            "reason": result.reason,
            "min_separation_m": result.min_separation_m,
            "digest": result.digest,
        }
        for i in range(boats):
            row = {**of_run, "boat": i + 1}
            if result.boats:
                row |= result.boats[i]
                row |= {f"s_{name}": result.states[i].get(name, 0.0) for name in states}
            rows.append(row)
    return pa.Table.from_pylist(rows, _schema(states))


def _schema(states: Sequence[str]) -> pa.Schema:
    return pa.schema(
        [
            ("run", pa.int32()),
            ("seed", pa.int64()),
            ("boat", pa.int16()),
            ("outcome", pa.string()),
            ("reason", pa.string()),
            *((name, pa.float64()) for name in _FIGURES),
            ("min_separation_m", pa.float64()),
            *((f"s_{name}", pa.float64()) for name in states),
            ("digest", pa.string()),
        ]
    )


def draws(sampler: Sampler, runs: int) -> pa.Table:
    """The draws, one row for each run and key: a number in `value`, or a word in `text`."""
    rows = []
    for run in range(runs):
        for key, drawn in sampler.draws(run).items():
            value = {"text": drawn} if isinstance(drawn, str) else {"value": float(drawn)}
            rows.append({"run": run, "key": key, **value})
    columns = [("run", pa.int32()), ("key", pa.string())]
    return pa.Table.from_pylist(
        rows, pa.schema([*columns, ("value", pa.float64()), ("text", pa.string())])
    )


def seconds(results: Sequence[RunResult]) -> pa.Table:
    """One row for each run that sailed, boat and second: distance from the slot, heading error."""
    sailed = [result for result in results if result.boats]
    shapes = [result.error_m.shape for result in sailed]
    grids = [np.indices(shape).reshape(2, -1) for shape in shapes]
    runs = [np.full(grid.shape[1], r.run) for r, grid in zip(sailed, grids, strict=True)]
    errors = [result.error_m.ravel() for result in sailed]
    headings = [result.psi_rad.ravel() for result in sailed]
    boat, second = np.concatenate([np.zeros((2, 0), int), *grids], axis=1)
    return pa.table(
        {
            "run": _joined(runs).astype(np.int32),
            "boat": (boat + 1).astype(np.int16),
            "t_s": second.astype(np.float32),
            "error_m": _joined(errors).astype(np.float32),
            "psi_rad": _joined(headings).astype(np.float32),
        }
    )


def _joined(arrays: Sequence[Array]) -> Array:
    return np.concatenate([np.zeros(0), *arrays])


def envelopes(results: Sequence[RunResult]) -> pa.Table:
    """Percentiles of the distance from the slot over the runs that sailed.

    One row for each boat and second. A percentile is the least distance that this share of the runs
    does not exceed; a diverged run's distance is infinite.
    """
    error = distances(results)
    n, boats, length = error.shape
    boat, second = np.indices((boats, length)).reshape(2, -1)
    levels: Array = np.zeros((len(PERCENTILES), 0), np.float32)
    if n:
        shares = np.array(PERCENTILES) / 100
        levels = np.quantile(error, shares, axis=0, method="inverted_cdf").reshape(len(shares), -1)
    diverged = sum(result.outcome == "diverged" for result in results)
    return pa.table(
        {
            "boat": (boat + 1).astype(np.int16),
            "t_s": second.astype(np.float32),
            **{f"p{p}": level for p, level in zip(PERCENTILES, levels, strict=True)},
            "n": np.full(boat.size, n),
            "n_diverged": np.full(boat.size, diverged),
        }
    )


def content_digest(content: pa.Table) -> str:
    """SHA-256 of a table's content, independent of the library's version."""
    return hashlib.sha256(json.dumps(content.to_pydict()).encode()).hexdigest()


def parquet(content: pa.Table) -> bytes:
    """A table as a Parquet file."""
    sink = pa.BufferOutputStream()
    pq.write_table(content, sink)
    return bytes(sink.getvalue())
