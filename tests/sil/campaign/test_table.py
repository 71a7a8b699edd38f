# SPDX-License-Identifier: MIT
"""The tables of a campaign, from made-up results."""

import io
import math
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from sil.campaign import table
from sil.campaign.run_outcome import RunResult
from tests.sil.campaign.short import result, sampler

FAILED = RunResult(2, 7, "failed", "lost its process")
RUNS = [result(0, [[1, 2], [3, 4]]), result(1, [[5, 6], [7, 8]], "diverged"), FAILED]


def test_the_table_has_a_row_for_each_run_and_boat_and_null_for_missing_figures() -> None:
    rows = table.table(RUNS, 2, ["FORMATION", "HOLD"]).to_pylist()
    assert [(row["run"], row["boat"]) for row in rows] == [(r, b) for r in range(3) for b in (1, 2)]
    assert [row["outcome"] for row in rows[::2]] == ["ok", "diverged", "failed"]
    assert rows[3]["rms_error_m"] == 1.1 and rows[3]["s_FORMATION"] == 1.0
    assert rows[3]["s_HOLD"] == 0.0 and rows[3]["settling_time_s"] is None
    assert rows[4]["rms_error_m"] is None and rows[4]["s_FORMATION"] is None
    assert rows[4]["reason"] == "lost its process" and rows[4]["seed"] == 7


def test_the_seconds_table_has_a_row_for_each_run_boat_and_second() -> None:
    rows = table.seconds(RUNS).to_pylist()
    assert [tuple(row.values()) for row in rows] == [
        (0, 1, 0.0, 1.0, 0.5),
        (0, 1, 1.0, 2.0, 1.0),
        (0, 2, 0.0, 3.0, 1.5),
        (0, 2, 1.0, 4.0, 2.0),
        (1, 1, 0.0, 5.0, 2.5),
        (1, 1, 1.0, 6.0, 3.0),
        (1, 2, 0.0, 7.0, 3.5),
        (1, 2, 1.0, 8.0, 4.0),
    ]
    assert table.seconds([FAILED]).num_rows == 0


def test_a_percentile_is_the_value_that_its_share_of_runs_does_not_exceed() -> None:
    rng = np.random.default_rng(5)
    errors = rng.exponential(size=(100, 1, 3))
    runs = [
        result(run, error.tolist(), "diverged" if run < 8 else "ok")
        for run, error in enumerate(errors)
    ]
    rows = table.envelopes(runs).to_pylist()
    assert [(row["boat"], row["t_s"]) for row in rows] == [(1, 0.0), (1, 1.0), (1, 2.0)]
    for second, row in enumerate(rows):
        ranked = [*sorted(errors[8:, 0, second].astype(np.float32).tolist()), *[math.inf] * 8]
        for percent in (5, 25, 50, 75, 95):
            assert row[f"p{percent}"] == ranked[percent - 1]
        assert row["p95"] == math.inf and row["n"] == 100 and row["n_diverged"] == 8


def test_a_failed_campaign_has_empty_tables() -> None:
    assert table.envelopes([FAILED]).num_rows == 0
    assert table.envelopes([FAILED]).column_names == table.envelopes(RUNS).column_names


def test_draws_are_numbers_or_words(tmp_path: Path) -> None:
    made = sampler(tmp_path)
    rows = table.draws(made, 2).to_pylist()
    assert len(rows) == 2 * 14
    drawn = made.draws(1)
    of_run = {row["key"]: row for row in rows if row["run"] == 1}
    assert of_run.keys() == drawn.keys()
    assert of_run["boat.2.eta.1"]["value"] == drawn["boat.2.eta.1"]
    assert of_run["navigation.message"]["text"] == drawn["navigation.message"]
    assert of_run["navigation.message"]["value"] is None


@pytest.mark.parametrize("change", [{"digest": "e"}, {"min_separation_m": 1.0 + 2e-16}])
def test_digest_shows_any_change(change: dict[str, object]) -> None:
    rows = table.table(RUNS, 2, ["FORMATION"])
    changed = [RunResult(**{**vars(RUNS[0]), **change}), *RUNS[1:]]
    other = table.table(changed, 2, ["FORMATION"])
    assert table.content_digest(rows) == table.content_digest(table.table(RUNS, 2, ["FORMATION"]))
    assert table.content_digest(rows) != table.content_digest(other)


def test_parquet_keeps_a_table() -> None:
    rows = table.table(RUNS, 2, ["FORMATION"])
    assert pq.read_table(io.BytesIO(table.parquet(rows))).equals(rows)
