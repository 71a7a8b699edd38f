# SPDX-License-Identifier: MIT
"""Draws of a campaign: distributions, independence, errors."""

import math
from itertools import combinations
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest

from sil.campaign.sampling import Sampler
from sil.scenario import scenario
from sil.scenario.scenario import ScenarioError
from sil.scenario.wiring import VIRTUAL_LEADER_SYSTEM
from tests.sil.campaign.short import SHORT, sampler, short

FREE = "[[vary]]\nkey = {key}\n{how}\n"


def vary(key: str, how: str) -> str:
    return FREE.format(key=f'"{key}"', how=how)


def test_a_draw_is_that_of_seed_run_and_key_alone(tmp_path: Path) -> None:
    drawn = sampler(tmp_path).draws(17)
    spawn_key = (17, crc32(b"boat.2.eta.3"))
    rng = np.random.default_rng(np.random.SeedSequence(1, spawn_key=spawn_key))
    assert drawn["boat.2.eta.3"] == rng.normal(0.0, 5.0)
    spawn_key = (17, crc32(b"parameters.LAW_KX"))
    rng = np.random.default_rng(np.random.SeedSequence(1, spawn_key=spawn_key))
    assert drawn["parameters.LAW_KX"] == pytest.approx(0.2 * rng.uniform(0.5, 1.5), rel=1e-6)


def test_other_vary_tables_and_their_order_change_no_draw(tmp_path: Path) -> None:
    few = sampler(tmp_path)
    more = sampler(tmp_path, vary("link.loss", "uniform = [0, 0.1]"))
    head, *tables = SHORT.split("[[vary]]\n")
    turned = head + "".join(f"[[vary]]\n{table}" for table in reversed(tables))
    (tmp_path / "turned.toml").write_text(turned, encoding="utf-8")
    other = Sampler(scenario.read(tmp_path / "turned.toml"))
    for run in (0, 3, 1000):
        assert few.draws(run) == other.draws(run)
        assert few.draws(run).items() <= more.draws(run).items()
        assert few.scenario(run).seed == more.scenario(run).seed == few.seed_of(run)


def test_runs_seeds_and_boats_differ(tmp_path: Path) -> None:
    source = scenario.read(short(tmp_path))
    draws = [Sampler(source, seed).draws(run) for seed in (1, 2) for run in (0, 1)]
    numbers = [draw[f"boat.{i}.eta.{k}"] for draw in draws for i in (1, 2) for k in (1, 2, 3)]
    assert len(set(numbers)) == 24
    assert len({Sampler(source, seed).seed_of(run) for seed in (1, 2) for run in (0, 1)}) == 4


def test_scenario_of_a_run_differs_only_by_its_draws(tmp_path: Path) -> None:
    made = sampler(tmp_path)
    nominal = made.nominal
    for run in range(5):
        drawn, chosen = made.draws(run), made.scenario(run)
        assert chosen.boat[1].eta == tuple(drawn[f"boat.2.eta.{i}"] for i in (1, 2, 3))
        assert chosen.parameters["LAW_KX"] == drawn["parameters.LAW_KX"]
        assert chosen.navigation.message == drawn["navigation.message"]
        assert chosen.vary == () and chosen.boat[1].offset_m == nominal.boat[1].offset_m
        assert chosen.vessels() == nominal.vessels() and chosen.link == nominal.link


def test_draws_have_the_distribution_of_the_file(tmp_path: Path) -> None:
    made = sampler(tmp_path, vary("boat.1.nu.2", "uniform = [-1, 3]"))
    draws = [made.draws(run) for run in range(2000)]
    north = np.array([draw["boat.1.eta.1"] for draw in draws])
    sway = np.array([draw["boat.1.nu.2"] for draw in draws])
    assert abs(north.mean()) < 0.4 and north.std() == pytest.approx(5.0, rel=0.05)
    assert -1.0 <= sway.min() < -0.99 and 2.99 < sway.max() < 3.0
    odometry = sum(draw["navigation.message"] == "odometry" for draw in draws)
    assert 900 < odometry < 1100


@pytest.mark.parametrize(
    ("key", "own"),
    [
        ("boat.*.vessel.m11", [1.5, 3.0]),  # of all, its own
        ("boat.*.parameters.VES_M11", [2.0, 2.5]),
        ("boat.2.parameters.LAW_KPSI", [0.2]),  # the paper's
        ("parameters.FS_LEADER_S", [1.0]),  # the firmware's default
        ("boat.2.propellers.forward_max_N", [50.0]),
        ("white_noise.power", [0.1]),
        ("navigation.position_noise_m", [0.0]),
        ("leader.input.1.surge_N", [2.0]),
        ("boat.2.nu.3", [0.0]),
        ("boat.*.parameters.FORM_OFS_N", [0.0, -2.0]),  # its place
        ("boat.*.parameters.FORM_LEADER", [VIRTUAL_LEADER_SYSTEM, 1.0]),
        ("boat.*.parameters.MAV_SYSID", [1.0, 2.0]),
        ("parameters.CTL_RATE", [100.0]),  # the scenario's
    ],
)
def test_a_draw_scales_the_number_in_force_or_is_added_to_it(
    tmp_path: Path, key: str, own: list[float]
) -> None:
    tables = "[vessel]\nm11 = 1.5\n[parameters]\nVES_M11 = 2.0\n[boat.2.vessel]\nm11 = 3.0\n"
    tables += "[boat.2.parameters]\nVES_M11 = 2.5\n"
    made = {
        how: sampler(tmp_path, tables + vary(key, f'choice = [3]\ncombine = "{how}"'))
        for how in ("scale", "add")
    }
    keys = [key.replace("*", str(i)) for i in (1, 2)][: len(own)]
    for name, value in zip(keys, own, strict=True):
        assert made["scale"].draws(0)[name] == pytest.approx(3.0 * value)
        assert made["add"].draws(0)[name] == pytest.approx(3.0 + value)
        made["add"].scenario(0)
    if key == "boat.*.vessel.m11":
        assert [v.m11 for v in made["scale"].scenario(4).vessels()] == [1.5, 4.5, 9.0, 4.5, 4.5]


@pytest.mark.parametrize(
    ("key", "how", "said"),
    [
        ("boat.*.etta", "normal = [0, 1]", 'no "etta" in "boat.1"'),
        ("boat.5.eta", "normal = [0, 1]", 'no "5" in "boat"'),
        ("boat.*.nu.0", "normal = [0, 1]", 'no "0" in "boat.1.nu"'),
        ("lnk.loss", "normal = [0, 1]", 'no key "lnk"'),
        ("parameters.LAW_KZ", "normal = [0, 1]", 'no "LAW_KZ" in "parameters"'),
        ("link", "normal = [0, 1]", "a table, not a number"),
        ("seed", "choice = [1]", "not varied"),
        ("rate_hz", "choice = [100]", "not varied"),
        ("boat.2.follows", "choice = [0]", "not varied"),
        ("boat.1.eta.1", "normal = [0, 1]", '"boat.1.eta.1" is varied twice'),
        ("boat.01.eta.1", "normal = [0, 1]", 'no "01" in "boat"'),
        ("boat.1.eta.01", "normal = [0, 1]", 'no "01" in "boat.1.eta"'),
        ("boat.1.nu.\u0661", "normal = [0, 1]", 'in "boat.1.nu"'),
        (
            "boat.2.parameters.LAW_KX",
            "normal = [0, 1]",
            '"boat.2.parameters.LAW_KX": varied of all',
        ),
        (
            "parameters.FORM_OFS_N",
            'normal = [0, 1]\ncombine = "add"',
            "each boat has its own: vary",
        ),
        ("link.loss", "uniform = [-1e308, 1e308]", "too far apart"),
        ("link.loss", "", "must have one of normal, uniform, choice"),
        ("link.loss", "normal = [0, 1]\nuniform = [0, 1]", "must have one of"),
        ("link.loss", "normal = [0, -1]", "normal = [0.0, -1.0]: a standard deviation"),
        ("link.loss", "uniform = [1, 0]", "uniform = [1.0, 0.0]: the lower"),
        ("leader.navigation.message", 'choice = ["local"]\ncombine = "add"', "needs numbers"),
        ("link.loss", 'choice = ["much"]\ncombine = "add"', "needs numbers"),
    ],
)
def test_a_key_that_cannot_be_varied_is_reported_with_file_and_line(
    tmp_path: Path, key: str, how: str, said: str
) -> None:
    with pytest.raises(ScenarioError) as told:
        sampler(tmp_path, vary(key, how))
    line = SHORT.count("\n") + 2
    assert f'short.toml:{line}: "vary.key" = "{key}": ' in str(told.value)
    assert said in str(told.value)


def test_a_parameter_of_all_is_not_varied_where_a_boat_has_its_own(tmp_path: Path) -> None:
    own = "[boat.2.parameters]\nFS_LEADER_S = 1.0\n"
    with pytest.raises(ScenarioError) as told:
        sampler(tmp_path, own + vary("parameters.FS_LEADER_S", "uniform = [1, 2]"))
    assert 'boat 2 has its own: vary "boat.*.parameters.FS_LEADER_S"' in str(told.value)


def test_an_array_of_all_and_a_boats_own_are_not_both_varied(tmp_path: Path) -> None:
    both = [vary("boat.2.navigation.origin_m.1", "uniform = [1, 2]")]
    both.append(vary("navigation.origin_m", "uniform = [1, 2]"))
    for tables in ("".join(both), "".join(both[::-1])):
        with pytest.raises(ScenarioError, match="varied of all boats and of one"):
            sampler(tmp_path, tables)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("normal = [0]", '"vary.4.normal" = [0]: must have 2 numbers'),
        ("choice = []", '"vary.4.choice" = []'),
        ("chioce = [1]", 'unknown key "vary.4.chioce" (did you mean "choice"?)'),
        ('normal = [0, 1]\ncombine = "times"', '"vary.4.combine" = "times"'),
    ],
)
def test_an_invalid_vary_is_refused(tmp_path: Path, how: str, said: str) -> None:
    with pytest.raises(ScenarioError) as told:
        sampler(tmp_path, vary("link.loss", how))
    assert said in str(told.value)


def test_an_impossible_draw_is_reported_with_run_key_value_and_line(tmp_path: Path) -> None:
    made = sampler(tmp_path, vary("link.loss", "normal = [0.5, 0.5]"))
    bad = next(run for run in range(100) if not 0.0 <= float(made.draws(run)["link.loss"]) <= 1.0)
    with pytest.raises(ScenarioError) as told:
        made.scenario(bad)
    line = SHORT.count("\n") + 2
    assert str(told.value).startswith(f"run {bad}: ") and f"short.toml:{line}: " in str(told.value)
    assert f'"link.loss" = {made.draws(bad)["link.loss"]}: must be' in str(told.value)


def test_a_single_run_ignores_vary(tmp_path: Path) -> None:
    assert scenario.load(short(tmp_path)).boat == scenario.load("diamond").boat


def test_only_runs_whose_boats_would_start_too_near_are_drawn_again(
    tmp_path: Path,
) -> None:
    free, wide = sampler(tmp_path), sampler(tmp_path, overrides=("start_apart_m=4",))
    again = 0
    for run in range(60):
        starts = [[boat.eta[:2] for boat in made.scenario(run).boat] for made in (free, wide)]
        near = [min(math.dist(a, b) for a, b in combinations(places, 2)) for places in starts]
        assert near[1] >= 4.0
        if near[0] >= 4.0:
            assert free.draws(run) == wide.draws(run)
        else:
            again += 1
    assert 20 < again < 60


def test_an_impossible_start_distance_is_reported_with_run_and_distance(
    tmp_path: Path,
) -> None:
    with pytest.raises(ScenarioError, match=r"run 3: no start in 1000 draws is 1000\.0 m apart"):
        sampler(tmp_path, overrides=("start_apart_m=1000",)).scenario(3)
