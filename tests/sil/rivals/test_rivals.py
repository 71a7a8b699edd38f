# SPDX-License-Identifier: MIT
"""The short form of the table of rivals, and the page's figures."""

import re

import numpy as np
import pytest

from sil.lockstep.metrics import wrap
from sil.rivals import rival_table
from sil.rivals.judge import Figures, figures
from sil.rivals.rivals import GAINS, GRID, KEEP_S, OURS, RIVALS, sail
from sil.rivals.routes import ROUTES, WEATHERS, scenarios_of
from tests import measurements

SHORT_S = 60.0


@pytest.mark.parametrize("name", [OURS, *RIVALS])
def test_everybody_sails_the_first_minute_of_a_sine(name: str) -> None:
    it = sail(name, ["sine"], "still", most_s=SHORT_S)["sine"]
    assert it.mean_m < 0.12 and it.worst_m < 0.5 and it.speed > 0.9
    assert np.isnan(it.followers_m) == (name not in (OURS, "Rover"))


def test_a_run_repeats_itself() -> None:
    first, again = (sail("ALOS", ["sine"], "sea", most_s=20.0) for _ in range(2))
    assert first["sine"].mean_m == again["sine"].mean_m


@pytest.mark.nightly
@pytest.mark.parametrize("name", [name for name in (OURS, *RIVALS) if name != "NMPC"])
def test_the_figures_are_those_of_the_page(name: str) -> None:
    """NMPC's are renewed by `flotilla rivals --write` only: it takes minutes."""
    compare(name, list(ROUTES))


def test_the_figures_of_a_route_are_those_of_the_page() -> None:
    compare("ALOS", ["sharp angles"])


def compare(name: str, routes: list[str]) -> None:
    found = sail(name, routes, "still")
    column = [OURS, *RIVALS].index(name)
    for route in routes:
        noted = measurements.numbers(measurements.row(f"rivals: {route}, calm")[column])
        told = measurements.numbers(rival_table.cell(found[route]))
        assert noted == pytest.approx(told, rel=0.05, abs=0.011), route


def test_the_page_has_all_rows_and_rivals() -> None:
    text = rival_table.PAGE.read_text(encoding="utf-8")
    made = text.partition(rival_table.BEGIN)[2].partition(rival_table.END)[0].splitlines()
    assert [cell.strip() for cell in made[0].split("|")[2:-1]] == [OURS, *RIVALS]
    assert len(made) == 2 + len(ROUTES) * len(WEATHERS)
    assert all(len(re.findall(r"\|", line)) == 3 + len(RIVALS) for line in made)


@pytest.mark.parametrize("name", RIVALS)
def test_the_gains_are_of_the_grid(name: str) -> None:
    assert all(gain in row for gain, row in zip(GAINS[name], GRID[name], strict=True))


def test_a_boat_exactly_on_the_plan_is_judged_perfect() -> None:
    (one,) = scenarios_of(["square"], "still")
    plan = one.route()[:: round(KEEP_S / one.step_s)]
    eta = np.stack([plan[:, :3]] * 4, axis=1)
    eta[:, 1:, :2] += [boat.offset_m for boat in one.boat[1:]]
    eta[..., 2] = wrap(eta[..., 2])
    it = figures(one, eta, KEEP_S, fleet=True)
    assert it.mean_m < 0.01 and it.speed == pytest.approx(1.0, abs=0.001)
    assert it.followers_m == pytest.approx(0.0, abs=1e-9)
    eta[:, 0, 1] += 0.5
    eta[:, 2, 0] += 0.2
    worse = figures(one, eta, KEEP_S, fleet=True)
    assert 0.2 < worse.mean_m <= 0.51 and worse.followers_m == pytest.approx(0.54, abs=0.01)


def test_a_boat_that_never_arrives_has_no_speed() -> None:
    (one,) = scenarios_of(["square"], "still")
    it = figures(one, np.zeros((3000, 1, 3)), KEEP_S, fleet=False)
    assert it.speed == 0.0 and rival_table.cell(it).endswith("lost")


def test_a_cell_leaves_out_a_figure_that_is_nan() -> None:
    assert rival_table.cell(Figures(0.031, 0.204, 0.996, 0.068)) == "0.03 / 0.20; 100 %; 0.07"
    assert rival_table.cell(Figures(0.031, 0.204, 0.996, float("nan"))) == "0.03 / 0.20; 100 %"
