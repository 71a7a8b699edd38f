# SPDX-License-Identifier: MIT
"""The page of made-up campaigns: diverged runs are never averaged away."""

import re
from html import unescape
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sil.campaign import campaign_report, finished, rerun, run_outcome
from tests.sil.campaign.made_up import DURATION_S, Made
from tests.turns import some

COMMAND = "flotilla campaign made_up"
COPY = '<button type="button" class="copy">Copy</button>'
LOSSY = Made(diverged=(3, 5, 8), failed=(2,))


def page_of(made: Made, folder: Path) -> str:
    made.write(folder)
    campaign_report.write(folder)
    return (folder / "report.html").read_text(encoding="utf-8")


def rows_under(heading: str, page: str) -> list[list[str]]:
    """Cells of the table under a heading, its head first."""
    table = page.partition(f"<h2>{heading}")[2].partition("<h2>")[0]
    cells = [re.findall(r"<t[hd]>(.*?)</t[hd]>", row) for row in re.findall("<tr.*</tr>", table)]
    return [[unescape(cell) for cell in row] for row in cells]


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("lossy")
    t_s = np.arange(0.0, DURATION_S, 0.1)
    error = np.tile(np.exp(-t_s / 10.0)[:, None, None], (1, 4, 3))
    eta = np.tile(t_s[:, None, None], (1, 5, 3)) + np.arange(5)[:, None]
    np.savez(folder / "nominal.npz", t_s=t_s, eta=eta, error=error)
    LOSSY.write(folder)
    for run in (3, 5):
        sail_again(folder, run)
    is_now_of(folder, 5)
    campaign_report.write(folder)
    return (folder / "report.html").read_text(encoding="utf-8")


def sail_again(folder: Path, run: int) -> None:
    place = rerun.place(folder, run)
    place.mkdir(parents=True)
    t_s = np.arange(0.0, 2.0, 0.1)
    np.savez(place / "trace.npz", t_s=t_s, eta=np.ones((20, 5, 3)), nu=np.zeros((20, 5, 3)))


def is_now_of(folder: Path, run: int) -> None:
    """Put the digest of the replayed run's motion into the table."""
    with np.load(rerun.place(folder, run) / "trace.npz") as trace:
        digest = run_outcome.motion_digest(trace)
    path = folder / "table.parquet"
    rows = [row | {"digest": digest} if row["run"] == run else row for row in rows_of(path)]
    pq.write_table(pa.Table.from_pylist(rows), path)


def rows_of(path: Path) -> list[dict[str, object]]:
    return list(pq.read_table(path).to_pylist())


def test_page_carries_both_pictures_and_needs_no_other_file(page: str) -> None:
    assert page.count('src="data:image/png;base64,') == 2
    assert not re.search(r"https?://|<script src|<link", page)
    assert 'name="viewport"' in page


def test_page_links_only_the_replay_that_matches_the_table(page: str) -> None:
    assert re.findall(r"href=\"(.*?)\"", page) == ["runs/5/report.html"]


def test_page_begins_with_how_the_runs_ended_and_their_picture(page: str) -> None:
    verdict = re.search(r'<p class="verdict bad">(.*?)</p>', page)
    assert verdict is not None
    assert re.fullmatch(r"\d+ of 40 runs settled; in .*; 3 diverged; 1 failed", verdict[1])
    assert page.index(verdict[0]) < page.index("<img ") < page.index("Runs that diverged or failed")


def test_every_lost_run_is_listed_with_its_reason_and_the_command_to_replay_it(page: str) -> None:
    _, *rows = rows_under("Runs that diverged or failed", page)
    assert [row[:2] for row in rows] == [
        ["2", "failed"],
        ["3", "diverged"],
        ["5", "diverged"],
        ["8", "diverged"],
    ]
    assert rows[0][2:4] == ["boat 1 <failed>", f"<code>{COMMAND} --run 2</code> {COPY}"]


def test_worst_runs_are_listed_in_order_without_the_lost_ones(page: str) -> None:
    _, *rows = rows_under("The worst of the runs", page)
    errors_m = [float(row[2]) for row in rows]
    assert len(rows) == 5 and errors_m == sorted(errors_m, reverse=True)
    assert not {"2", "3", "5", "8"} & {row[0] for row in rows}
    # 1.6 times the RMS of the run's worst boat, as they were made
    assert errors_m == pytest.approx([1.6 * float(row[3]) for row in rows], abs=2e-4)


def test_runs_in_which_two_boats_came_too_near_are_listed_nearest_first(page: str) -> None:
    verdict = re.search(r"in (\d+) two boats came nearer", page)
    _, *rows = rows_under("Runs in which two boats came nearer", page)
    apart_m = [float(row[1]) for row in rows]
    assert verdict and len(rows) == min(5, int(verdict[1])) and len(rows) > 1
    assert apart_m == sorted(apart_m) and max(apart_m) < 1.0
    assert rows[0][2] == f"<code>{COMMAND} --run {rows[0][0]}</code> {COPY}"


def test_percentile_that_reaches_into_the_runs_that_diverged_is_infinite(page: str) -> None:
    head, *rows = rows_under("Distances from the slots from 60 s on", page)
    # 3 of the 39 that sailed are 7.7 %
    for row in some(rows):
        cells = dict(zip(head, row, strict=True))
        assert cells["95 %"] == cells["largest"] == "∞"
        assert 0.2 < float(cells["median"]) < float(cells["75 %"]) < 2.0


def test_diverged_boats_are_left_out_of_the_mean_thrust(page: str) -> None:
    _, *rows = rows_under("Thrust", page)
    # theirs, of every twelfth run, is ten times as much
    assert all(4.0 < float(number) < 8.0 for _, *row in some(rows) for number in row[:2])


def test_no_more_than_twenty_lost_runs_are_listed_and_the_others_counted(tmp_path: Path) -> None:
    page = page_of(Made(diverged=tuple(range(30))), tmp_path)
    assert len(rows_under("Runs that diverged or failed", page)) == 1 + 20
    assert "and 10 more" in page


@pytest.mark.parametrize(
    "made",
    [
        Made(runs=1, boats=1),
        Made(runs=3, boats=2, diverged=(0, 1, 2)),
        Made(runs=2, boats=2, failed=(0, 1)),
        Made(runs=2, boats=8),
    ],
    ids=["one boat", "all diverged", "all failed", "many boats"],
)
def test_campaigns_of_one_boat_many_boats_or_only_lost_runs_have_a_page(
    made: Made, tmp_path: Path
) -> None:
    page = page_of(made, tmp_path)
    assert f"{made.runs} runs" in page and ">nan" not in page
    assert page.count("data:image/png") == (0 if made.failed else 1)


def test_unfinished_campaign_is_refused_with_the_command_that_resumes_it(
    tmp_path: Path,
) -> None:
    Made(runs=2).write(tmp_path)
    (tmp_path / "parts").mkdir()
    with pytest.raises(ValueError, match="not finished; to go on: flotilla campaign made_up"):
        finished.read(tmp_path)


def test_percentiles_name_the_number_of_their_runs(page: str) -> None:
    assert "from 60 s on (m): 39 of 40 runs; 1 failed are not in it</h2>" in page
