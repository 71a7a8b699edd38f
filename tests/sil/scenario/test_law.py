# SPDX-License-Identifier: MIT
"""The LAW_* parameters of a boat, by the scenario, its law, --law and --param."""

from pathlib import Path

import flotilla
import pytest

from sil.cli.main import main
from sil.lockstep.recording import Recording
from sil.scenario import law, scenario
from sil.scenario.agents import parameters_of
from sil.scenario.law import Law

GAINS = {"LAW_KX": 0.2, "LAW_KPSI": 0.2, "LAW_KDU": 10.0, "LAW_KDR": 10.0}
EXTENSIONS = ("LAW_OBS_BW", "LAW_XT_DIST", "LAW_CUR_BW", "LAW_U_MAX", "LAW_R_MAX", "LAW_REF")
PAPER = {**GAINS, **dict.fromkeys(EXTENSIONS, 0.0)}
JUDGED = {"FS_SLOT_M": 0.0, "FS_SEP_M": 0.0}  # the paper states no limit for its boats' errors

ONE_BOAT = """\
duration_s = 10.0
{law}
[leader]
[parameters]
LAW_KX = 0.3
LAW_KDU = 80.0
LAW_OBS_BW = 0.5
SR_STATE = 20.0
[[boat]]
follows = 0
offset_m = [0, 0]
eta = [1, 2, 0.5]
parameters = {{ LAW_U_MAX = 1.0, LAW_KDR = 90.0 }}
"""


def told(
    folder: Path,
    law_key: str = "",
    law_override: Law | None = None,
    overrides: tuple[str, ...] = (),
    parameters: dict[str, float] | None = None,
) -> dict[str, float]:
    """LAW_* of the boat of ONE_BOAT."""
    path = folder / "one.toml"
    path.write_text(ONE_BOAT.format(law=law_key), encoding="utf-8")
    chosen = scenario.load(path, overrides, law_override)
    given = parameters_of(chosen, parameters or {})[0]
    assert given["SR_STATE"] == 20.0, "what is no part of a law stays"
    return {name: value for name, value in given.items() if name.startswith("LAW_")}


OF_THE_FILE = {"LAW_KX": 0.3, "LAW_KDU": 80.0, "LAW_OBS_BW": 0.5, "LAW_U_MAX": 1.0, "LAW_KDR": 90.0}


def test_the_papers_law_has_its_gains_and_none_of_the_firmwares_extensions() -> None:
    assert law.parameters("paper") == PAPER | JUDGED
    known = {p["name"] for p in flotilla.parameter_list() if p["name"].startswith("LAW_")}
    assert known == set(PAPER), "a law that does not say all of it"


def test_the_products_law_sets_no_parameters() -> None:
    assert law.parameters("product") == {}


def test_a_scenario_is_sailed_with_the_products_law_and_its_own_gains(tmp_path: Path) -> None:
    assert told(tmp_path) == told(tmp_path, 'law = "product"') == OF_THE_FILE


def test_a_scenarios_gains_lie_over_its_law(tmp_path: Path) -> None:
    assert told(tmp_path, 'law = "paper"') == {**PAPER, **OF_THE_FILE}


@pytest.mark.parametrize("law_key", ["", 'law = "paper"', 'law = "product"'])
def test_another_law_replaces_the_scenarios_but_keeps_its_vessels_gains(
    tmp_path: Path, law_key: str
) -> None:
    kept = {"LAW_KDU": 80.0, "LAW_KDR": 90.0}
    assert told(tmp_path, law_key, "paper") == {**PAPER, **kept}
    assert told(tmp_path, law_key, "product") == (kept if "paper" in law_key else OF_THE_FILE)


def test_overrides_and_parameters_lie_over_another_law(tmp_path: Path) -> None:
    overrides = ("parameters.LAW_XT_DIST=3", "boat.1.parameters.LAW_KX=0.25")
    given = told(tmp_path, "", "paper", overrides, {"LAW_KPSI": 0.4})
    assert given == {
        **PAPER,
        "LAW_KDU": 80.0,
        "LAW_KDR": 90.0,
        "LAW_XT_DIST": 3.0,
        "LAW_KX": 0.25,
        "LAW_KPSI": 0.4,
    }


def test_diamond_is_the_papers_and_the_law_of_a_base_can_be_changed() -> None:
    assert scenario.load("diamond").law == "paper"
    assert scenario.load("leader_global").law == "paper"
    for name in ("straight", "current", "sea", "tree"):
        assert scenario.load(name).law == "product"
        assert scenario.load(name, (), "paper").law == "paper"
    overridden = scenario.load("diamond", (), "product")
    assert not [
        name for name in overridden.firmware_parameters(overridden.boat[0]) if "LAW" in name
    ]


def test_another_law_keeps_the_gains_of_each_size_of_boat() -> None:
    tree = scenario.load("tree", (), "paper")
    gains = [tree.firmware_parameters(boat)["LAW_KDU"] for boat in tree.boat]
    assert gains == pytest.approx([10 * s**2.5 for s in (1.25, 1, 1, 0.8, 0.8, 0.8, 0.8)], rel=1e-3)


@pytest.mark.parametrize("text", ["parameters = 3", "boat = 3", "boat = [3]", "parameters = []"])
def test_a_mistake_in_the_file_is_reported_with_another_law_too(tmp_path: Path, text: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(f"duration_s = 1\n{text}\n", encoding="utf-8")
    with pytest.raises(scenario.ScenarioError, match=r"wrong.toml:2"):
        scenario.load(path, (), "paper")


def test_the_command_line_knows_two_laws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["run", "diamond", "--law", "none", "--out", str(tmp_path / "out")])
    said = capsys.readouterr().err
    assert "product" in said and "paper" in said


def test_the_command_line_sails_the_law_that_it_names(tmp_path: Path) -> None:
    arguments = ["run", "turning", "--law", "product", "--set", "duration_s=1"]
    assert main([*arguments, "--param", "LAW_KPSI=0.4", "--out", str(tmp_path)]) == 0
    sailed = Recording(tmp_path / "recording.bin").header["boats"][0]["parameters"]
    expected = flotilla.Boat({"LAW_KPSI": 0.4}).parameters()
    for name in PAPER:
        assert sailed[name] == expected[name], name
