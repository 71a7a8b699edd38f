# SPDX-License-Identifier: MIT
"""Hulls chosen by name: what a file, its base, its boats and overrides say over them."""

from pathlib import Path

import pytest

from sil.scenario import presets
from sil.scenario.scenario import Scenario, ScenarioError, Vessel, load

OTTER, HERON = presets.load("otter"), presets.load("heron")


def written(folder: Path, text: str) -> Scenario:
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return load(path)


def test_hull_of_a_file_replaces_its_bases_tables_and_parameters(tmp_path: Path) -> None:
    fleet = written(tmp_path, 'base = "diamond"\nlaw = "product"\nhull = "otter"\n')
    assert fleet.hulls() == [OTTER.vessel.hull] * 5  # the virtual leader is one too
    assert {pair.forward_max_N for pair in fleet.propeller_pairs()} == {119.7}
    own = fleet.firmware_parameters(fleet.boat[0])
    assert own | presets.firmware(OTTER) == own
    assert own["SR_STATE"] == 100.0  # diamond's; the hull says nothing of it


def test_keys_of_the_file_change_its_hull(tmp_path: Path) -> None:
    text = 'base = "diamond"\nhull = "otter"\n[vessel]\nm11 = 90\n[parameters]\nVES_M11 = 91\n'
    fleet = written(tmp_path, text)
    assert {hull.m11 for hull in fleet.hulls()} == {90.0}
    assert {hull.m22 for hull in fleet.hulls()} == {OTTER.vessel.m22}
    assert fleet.firmware_parameters(fleet.boat[2])["VES_M11"] == 91.0


def test_override_of_the_law_chooses_the_hulls_gains_as_the_option_does() -> None:
    for name in ("paper", "product"):
        by_key = load("diamond", ["hull=otter", f"law={name}"])
        by_option = load("diamond", ["hull=otter"], name)
        assert by_key.law == by_option.law == name
        assert by_key.parameters == by_option.parameters


def test_a_boats_own_hull_replaces_the_fleets_hull_completely(tmp_path: Path) -> None:
    text = 'base = "diamond"\nhull = "otter"\n[boat.2]\nhull = "heron"\nvessel.d22 = 20\n'
    fleet = written(tmp_path, text)
    heron = fleet.vessels()[2]
    assert heron == Vessel(**{**HERON.vessel.model_dump(), "d22": 20.0})  # nothing of the Otter's
    assert fleet.vessels()[3] == OTTER.vessel
    assert fleet.propeller_pairs()[1].arm_m == HERON.propellers.arm_m
    told = [fleet.firmware_parameters(boat)["VES_M33"] for boat in fleet.boat]
    assert told == [41.45, 10.0, 41.45, 41.45]


def test_override_replaces_a_hull_and_a_boats() -> None:
    fleet = load("tree", ["hull=heron", "boat.1.hull=otter", "boat.1.vessel.d22=99"])
    assert fleet.vessels()[0] == HERON.vessel
    assert fleet.vessels()[1] == Vessel(**{**OTTER.vessel.model_dump(), "d22": 99.0})
    assert fleet.firmware_parameters(fleet.boat[0])["VES_M11"] == OTTER.vessel.m11


def test_fleet_by_its_shape_takes_hulls_of_single_boats() -> None:
    mixed = load("mixed")
    assert [vessel.m11 for vessel in mixed.vessels()[1:]] == [1.012, 16.5, 85.28, 31.8]
    assert mixed.vessels()[0] == Vessel()  # the virtual leader is the paper's


@pytest.mark.parametrize("how", ["file", "override"])
def test_papers_law_takes_no_extension_from_a_hull(how: str, tmp_path: Path) -> None:
    text = f'base = "diamond"\nhull = "heron"\nlaw = "{"paper" if how == "file" else "product"}"\n'
    path = tmp_path / "own.toml"
    path.write_text(text, encoding="utf-8")
    fleet = load(path, (), None if how == "file" else "paper")
    own = fleet.firmware_parameters(fleet.boat[0])
    assert (own["LAW_OBS_BW"], own["LAW_CUR_BW"], own["LAW_R_MAX"]) == (0.0, 0.0, 0.0)
    assert own["LAW_KDU"] == presets.firmware(HERON)["LAW_KDU"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('base = "diamond"\nhull = "oter"\n', 'own.toml:2: "hull": unknown hull "oter"; did you'),
        ('base = "diamond"\n[boat.3]\nhull = "x"\n', 'own.toml:3: "boat.3.hull": unknown hull "x"'),
        ('base = "diamond"\nhull = 3\n', 'own.toml:2: "hull" = 3: must be a valid string'),
        ('base = "diamond"\nhull = "../hulls/otter"\n', 'unknown hull "../hulls/otter"'),
    ],
)
def test_unknown_hull_is_reported_with_its_line(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as told:
        written(tmp_path, text)
    assert said in str(told.value)


def test_override_with_an_unknown_hull_is_refused() -> None:
    with pytest.raises(ScenarioError, match='did you mean "wamv"'):
        load("diamond", ["boat.2.hull=wamw"])
    with pytest.raises(ScenarioError, match="override"):
        load("diamond", ["boat.9.hull=wamv"])
