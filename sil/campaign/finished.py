# SPDX-License-Identifier: MIT
"""Reads the folder of a campaign: campaign.json and the Parquet tables."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from sil.plant.hull import Array

Columns = dict[str, npt.NDArray[Any]]
Mask = npt.NDArray[np.bool_]
OK, DIVERGED, FAILED = "ok", "diverged", "failed"


@dataclass(frozen=True)
class Campaign:
    """The content of campaign.json, and of table.parquet by runs (R) and boats (N).

    `runs` (R): the runs' numbers, ascending. `outcome`, `reason` and `digest` (R): one entry for
    each run. `cells`: the numeric columns (R, N) by name, NaN where the table is empty.
    """

    folder: Path
    header: dict[str, Any]
    runs: npt.NDArray[np.int64]
    outcome: npt.NDArray[np.str_]
    reason: npt.NDArray[np.str_]
    digest: npt.NDArray[np.str_]
    cells: dict[str, Array]

    @property
    def scenario(self) -> str:
        """The scenario's name."""
        return str(self.header["scenario"])

    @property
    def boats(self) -> int:
        """The number of boats in a run."""
        return int(self.cells["rms_error_m"].shape[1])

    @property
    def ok(self) -> Mask:
        """Mask (R) of the runs that neither diverged nor failed."""
        return np.asarray(self.outcome == OK)

    def worst(self, name: str) -> Array:
        """The largest value of column `name` in each run (R); NaN if a boat of the run has none."""
        return np.asarray(self.cells[name].max(axis=1))


def read(folder: Path) -> Campaign:
    """Read a campaign; ValueError, in one line, if there is none or it is unfinished."""
    header = _header(folder)
    if (folder / "parts").is_dir():
        raise ValueError(f"{folder} is not finished; to go on: {header.get('command')}")
    return tables(folder)


def tables(folder: Path) -> Campaign:
    """The same as `read`, for a campaign that has its tables but may not be finished."""
    header = _header(folder)
    table = columns(folder, "table")
    try:
        run, boat = table.pop("run"), table.pop("boat")
        runs, first, row = np.unique(run, return_index=True, return_inverse=True)
        texts = {
            name: table.pop(name)[first].astype(str) for name in ("outcome", "reason", "digest")
        }
        cells = {}
        for name, values in table.items():
            cells[name] = np.full((runs.size, boat.max()), np.nan)
            cells[name][row, boat - 1] = values
        return Campaign(folder, header, runs.astype(np.int64), cells=cells, **texts)
    except (KeyError, ValueError) as error:
        raise ValueError(f"{folder}/table.parquet is not a campaign's table: {error}") from None


def columns(folder: Path, stem: str) -> Columns:
    """The columns of `folder`/`stem`.parquet; numbers that are null are NaN."""
    path = folder / f"{stem}.parquet"
    if not path.is_file():
        again = "the campaign may be unfinished; the command that began it continues it"
        raise ValueError(f"no {path}: {again}")
    try:
        table = pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"{path} cannot be read: {error}") from None
    return {name: _array(table[name]) for name in table.column_names}


def _array(column: Any) -> npt.NDArray[Any]:
    if pa.types.is_null(column.type):
        column = column.cast(pa.float64())
    return np.asarray(column.to_numpy())


def _header(folder: Path) -> dict[str, Any]:
    path = folder / "campaign.json"
    if not path.is_file():
        make = f"flotilla campaign SCENARIO --runs N --out {folder}"
        raise ValueError(f"no campaign in {folder}: no campaign.json; make one with: {make}")
    try:
        header = json.loads(path.read_text(encoding="utf-8"))
        missing = {"scenario", "seed", "runs"} - header.keys()
    except (ValueError, AttributeError) as error:
        raise ValueError(f"{path} cannot be read: {error}") from None
    if missing:
        raise ValueError(f"{path} is not a campaign's: no {', '.join(sorted(missing))}")
    return dict(header)
