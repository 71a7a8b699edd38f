# SPDX-License-Identifier: MIT
"""The Monte Carlo of the page of results, from made-up campaigns."""

from pathlib import Path

import pytest

from sil.campaign import campaign, finished
from sil.results import published, results_campaigns
from sil.scenario import scenario
from tests.sil.campaign.made_up import Made
from tests.turns import some


def test_page_has_a_line_for_each_boat_and_counts_diverged_runs(tmp_path: Path) -> None:
    paper = finished.read(Made(boats=2, gain=2.0, scenario="one").write(tmp_path / "one"))
    product = finished.read(Made(boats=2, diverged=(3,), scenario="two").write(tmp_path / "two"))
    told = [results_campaigns.told(campaign) for campaign in (paper, product)]
    lines = results_campaigns.for_page(told).splitlines()
    assert lines[0] == "| boat | `one`: median | `one`: 95 % | `two`: median | `two`: 95 % |"
    figures = [[float(cell.split()[0]) for cell in line.split("|")[2:6]] for line in lines[2:4]]
    for median_1, high_1, median_2, high_2 in some(figures):
        assert median_1 == pytest.approx(2.0 * median_2, rel=0.1)
        assert median_1 < high_1 and median_2 < high_2
    assert "`two`: 39 ok, 1 diverged, 0 failed." in lines


def test_where_one_run_in_ten_diverged_the_95th_percentile_is_infinite(tmp_path: Path) -> None:
    made = Made(boats=1, diverged=tuple(range(4))).write(tmp_path)
    told = results_campaigns.told(finished.read(made))
    (line,) = results_campaigns.for_page([told]).splitlines()[2:3]
    assert line.endswith("| inf m |")


def test_campaign_that_was_not_finished_is_an_error(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(campaign, "main", lambda options, given, began_s: 130)
    with pytest.raises(ValueError, match="paper_monte_carlo was not finished"):
        results_campaigns.sail(tmp_path, 1)


def test_the_projects_page_has_one_place_for_campaigns_and_their_scenarios_exist() -> None:
    assert published.PAGE.read_text(encoding="utf-8").count(results_campaigns.BEGIN) == 1
    laws = {name: scenario.load(name).law for name in results_campaigns.NAMES.values()}
    assert laws == {name: law for law, name in results_campaigns.NAMES.items()}
