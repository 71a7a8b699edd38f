# SPDX-License-Identifier: MIT
"""Scenario files: their meaning; errors name file, line, key and remedy."""

import re
import tomllib
from pathlib import Path

import flotilla
import numpy as np
import pytest

from sil.lockstep.world import all_sailed, sail
from sil.plant.hull import HullParameters
from sil.plant.propeller import PropellerParameters
from sil.scenario.agents import parameters_of
from sil.scenario.formation import Formation
from sil.scenario.law import LAWS, Law
from sil.scenario.scenario import FOLDER, Propellers, Scenario, ScenarioError, Vessel, load
from sil.scenario.sections import Fault, Leader
from sil.wire.navigation_unit import Settings

TWO_BOATS = """\
duration_s = 10.0
seed = 3
[leader]
[[leader.input]]
surge_N = 2.0
[[leader.input]]
from_s = 5.0
surge_N = 1.0
[link]
loss = 0.1
[parameters]
LAW_KX = 0.2
[[boat]]
follows = 0
offset_m = [0, 0]
eta = [1, 2, 0.5]
[[boat]]
follows = 1
offset_m = [-2, -2]
eta = [0, 0, 0]
parameters = { LAW_KX = 0.3 }
[boat.vessel]
m11 = 2.0
"""


ROUTE = {"waypoints", "speed_mps", "corner_radius_m", "boat", "voyage_room_m", "voyage_share"}


def written(folder: Path, text: str) -> Path:
    path = folder / "pair.toml"
    path.write_text(text, encoding="utf-8")
    return path


def complaint(folder: Path, text: str, *overrides: str) -> str:
    """The error message for a file with `text`, without the folder's name."""
    with pytest.raises(ScenarioError) as caught:
        load(written(folder, text), overrides)
    return str(caught.value).replace(f"{folder}/", "")


def changed(line: str, new: str) -> str:
    assert re.search(rf"^{re.escape(line)}$", TWO_BOATS, re.MULTILINE)
    return TWO_BOATS.replace(f"{line}\n", f"{new}\n", 1)


def test_diamond_is_the_papers_formation() -> None:
    diamond = load("diamond")
    assert diamond.name == "diamond"
    assert [boat.follows for boat in diamond.boat] == [0, 1, 2, 3]
    assert [boat.offset_m for boat in diamond.boat] == [(0, 0), (-2, -2), (4, 0), (-2, -2)]
    assert diamond.boat[1].eta == (-3.45, 2.25, 1.02)
    nominal = HullParameters(m11=1.012, m22=1.982, m33=0.354, d11=3.436, d22=18.99, d33=0.864)
    assert diamond.hulls() == [nominal] * 5
    assert diamond.propeller_pairs() == [PropellerParameters(0.25, 50.0, 50.0, 0.0, 0.0)] * 4


def test_the_default_boat_is_the_one_that_the_firmware_expects_by_default() -> None:
    expected = flotilla.Boat().parameters()
    vessel, propellers = Vessel(), Propellers()
    for name in ("m11", "m22", "m33", "d11", "d22", "d33"):
        assert getattr(vessel, name) == pytest.approx(expected[f"VES_{name.upper()}"])
    for own, theirs in {
        "arm_m": "THR_ARM",
        "forward_max_N": "THR_FWD_MAX",
        "reverse_max_N": "THR_REV_MAX",
        "expo": "THR_EXPO",
    }.items():
        assert getattr(propellers, own) == pytest.approx(expected[theirs])


def test_sections_that_diamond_spells_out_are_the_defaults() -> None:
    diamond = load("diamond").model_dump()
    spelt_out = {"water", "wind", "waves", "white_noise", "mismatch", "vessel", "navigation"}
    for section in (*spelt_out, "link", "clocks", "rate_hz", "scalar"):
        default = Scenario.model_fields[section].default
        assert diamond[section] == getattr(default, "model_dump", lambda d=default: d)()


def test_diamond_shows_every_key() -> None:
    text = (FOLDER / "diamond.toml").read_text(encoding="utf-8")
    document = tomllib.loads(text)
    # of what it has none, it shows what there would be
    assert set(Scenario.model_fields) - document.keys() == {
        "name",
        "vary",
        "fault",
        "formation",
        "hull",
    }
    shown = (*Fault.model_fields, *Formation.model_fields, *ROUTE, "hull")
    assert all(f"\n# {key} = " in text for key in shown)
    assert document["leader"].keys() | ROUTE | {"navigation"} == Leader.model_fields.keys()
    for section in ("vessel", "propellers", "water", "wind", "waves", "white_noise", "mismatch"):
        model = Scenario.model_fields[section].annotation
        assert document[section].keys() == model.model_fields.keys(), section
    for section in ("navigation", "link", "clocks"):
        model = Scenario.model_fields[section].annotation
        assert document[section].keys() == model.model_fields.keys(), section


NAMES = sorted(path.stem for path in FOLDER.glob("*.toml"))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("law", LAWS)
def test_every_scenario_that_comes_along_sails(name: str, law: Law) -> None:
    (run,) = all_sailed(sail([load(name, ["duration_s=1"], law)], {}))
    assert len(run.trace["eta"]) == 101 and np.isfinite(run.trace["eta"]).all()


@pytest.mark.parametrize("name", NAMES)
def test_the_firmware_knows_the_nominal_boat_of_every_scenario(name: str) -> None:
    chosen = load(name)
    propellers, hulls = chosen.propeller_pairs(), chosen.hulls()[1:]
    for agent, (pair, hull) in enumerate(zip(propellers, hulls, strict=True), start=1):
        told = flotilla.Boat(parameters_of(chosen, {})[agent - 1]).parameters()
        assert told["THR_ARM"] == pytest.approx(pair.arm_m)
        assert told["THR_FWD_MAX"] == pytest.approx(pair.forward_max_N)
        assert told["THR_REV_MAX"] == pytest.approx(pair.reverse_max_N)
        assert told["THR_EXPO"] == pytest.approx(pair.expo)
        for key in ("m11", "m22", "m33"):
            assert told[f"VES_{key.upper()}"] == pytest.approx(getattr(hull, key)), name
        if not (hull.crossflow or hull.d11_quadratic):  # else linear drag is a fit
            for key in ("d11", "d22", "d33"):
                assert told[f"VES_{key.upper()}"] == pytest.approx(getattr(hull, key)), name


def test_hull_of_a_table_has_the_crossflow_of_its_draft() -> None:
    vessel = Vessel(m23=0.2, length_m=2.0, draft_m=0.2, crossflow_cd=1.1, d33_quadratic=3.0)
    assert vessel.hull.crossflow == pytest.approx(0.5 * 1025.0 * 0.2 * 1.1)
    assert (vessel.hull.m11, vessel.hull.m23, vessel.hull.length_m) == (1.012, 0.2, 2.0)
    assert vessel.hull.d33_quadratic == 3.0


def test_boat_may_deviate_from_the_common_hull_and_parameters(tmp_path: Path) -> None:
    pair = load(written(tmp_path, f"{TWO_BOATS}\n[vessel]\nd11 = 4.0\n"))
    assert [(hull.m11, hull.d11) for hull in pair.hulls()] == [(1.012, 4), (1.012, 4), (2.0, 4)]
    assert [pair.firmware_parameters(boat)["LAW_KX"] for boat in pair.boat] == [0.2, 0.3]


def test_virtual_leader_of_diamond_pushes_2_N_and_swings_its_rudder() -> None:
    times = np.array([[0.0, 0.005, 0.01], [20.0, 20.005, 20.01]])
    tau = load("diamond").leader.tau(times)
    np.testing.assert_allclose(tau[..., 0], 2.0)
    np.testing.assert_allclose(tau[..., 1], 0.3 * np.sin(0.3 * times))


def test_virtual_leader_changes_its_input_where_a_segment_starts(tmp_path: Path) -> None:
    leader = load(written(tmp_path, TWO_BOATS)).leader
    np.testing.assert_allclose(leader.tau(np.array([0.0, 4.99, 5.0, 9.0]))[:, 0], [2, 2, 1, 1])


def test_overrides_lie_over_the_file() -> None:
    overrides = ["link.delay_s=0.1", "boat.2.eta=[0, 0, 0]", "boat.2.eta.3 = 1", "scalar='double'"]
    diamond = load("diamond", [*overrides, "parameters.FS_COAST_S=2"])
    assert diamond.link.delay_s == 0.1
    assert diamond.boat[1].eta == (0, 0, 1)
    assert diamond.scalar == "double"
    assert diamond.firmware_parameters(diamond.boat[0])["FS_COAST_S"] == 2


@pytest.mark.parametrize("value", ["q16", " q16 ", "'q16'", '"q16"'])
def test_a_word_of_an_override_may_do_without_quotation_marks(value: str) -> None:
    assert load("diamond", [f"scalar={value}"]).scalar == "q16"


def test_a_byte_order_mark_before_a_scenario_is_no_mistake(tmp_path: Path) -> None:
    plain = written(tmp_path, OVER_DIAMOND)
    marked = tmp_path / "marked" / plain.name
    marked.parent.mkdir()
    marked.write_bytes(b"\xef\xbb\xbf" + plain.read_bytes())
    assert load(marked) == load(plain)


@pytest.mark.parametrize(
    ("line", "new", "told"),
    [
        ("loss = 0.1", "los = 0.1", 'pair.toml:10: unknown key "link.los" (did you mean "loss"?)'),
        (
            "loss = 0.1",
            "bandwidth_Hz = 1",
            "(allowed: delay_s, jitter_s, loss, rate_Bps, everyone)",
        ),
        ("[link]", "[lnk]", 'pair.toml:9: unknown key "lnk" (did you mean "link"?)'),
        (
            "offset_m = [-2, -2]",
            "ofset_m = [-2, -2]",
            'pair.toml:19: unknown key "boat.2.ofset_m" (did you mean "offset_m"?)',
        ),
        ("follows = 0", "", 'pair.toml:13: missing key "boat.1.follows"'),
        ("duration_s = 10.0", "", 'pair.toml:1: missing key "duration_s"'),
        ("loss = 0.1", 'loss = "0.1"', 'pair.toml:10: "link.loss" = "0.1": must be a valid number'),
        ("loss = 0.1", "loss = true", 'pair.toml:10: "link.loss" = true: must be a valid number'),
        ("seed = 3", "seed = 3.5", 'pair.toml:2: "seed" = 3.5: must be a valid integer'),
        ("[link]", "[[link]]", '"link" = [{"loss": 0.1}]: must be a table'),
        ("eta = [0, 0, 0]", "eta = 4", 'pair.toml:20: "boat.2.eta" = 4: must be an array'),
        ("eta = [0, 0, 0]", "eta = [0, 0]", '"boat.2.eta" = [0, 0]: must have 3 numbers'),
        ("offset_m = [0, 0]", "offset_m = [0, 0, 1]", '15: "boat.1.offset_m" = [0, 0, 1]: must h'),
        (
            "m11 = 2.0",
            "loss = 0.3",
            'unknown key "boat.2.vessel.loss" (for one boat, use a [[fault]] of',
        ),
        ("loss = 0.1", "loss = 1.5", "pair.toml:10: "),
        ("loss = 0.1", "loss = 1.5", '"link.loss" = 1.5: must be less than or equal to 1'),
        ("loss = 0.1", "loss = nan", '"link.loss" = NaN: must be a finite number'),
        ("m11 = 2.0", "m11 = 0", '23: "boat.2.vessel.m11" = 0: must be greater than 0'),
        ("seed = 3", 'law = "mine"', "2: \"law\" = \"mine\": must be 'product' or 'paper'"),
        (
            "m11 = 2.0",
            "m23 = 2.0",
            '23: "boat.2.vessel.m23" = 2.0: its square must be less than m22',
        ),
        ("[link]", "[mismatch]\nshare = 1.0\n[link]", '10: "mismatch.share" = 1.0: must be less'),
        (
            "[link]",
            "[white_noise]\npower = 0.1\nsample_s = 0.004\n[link]",
            'pair.toml:11: "white_noise.sample_s" = 0.004: a sample of 0.004 s is not a whole',
        ),
        (
            "seed = 3",
            'scalar = "half"',
            "\"scalar\" = \"half\": must be 'float', 'double' or 'q16'",
        ),
        ("LAW_KX = 0.2", "law_kx = 1", 'pair.toml:12: "parameters.law_kx": a parameter\'s name'),
        ("follows = 1", "follows = 2", '18: "boat.2.follows" = 2: boat 2 may follow agents 0 to 1'),
        ("from_s = 5.0", "from_s = 0", '7: "leader.input.2.from_s" = 0.0: must be later than 0.0'),
        ("loss = 0.1", "loss = ", 'pair.toml:10: not TOML: Invalid value, in "loss ="'),
        ("seed = 3", "seed = 3\nseed = 4", "pair.toml:3: not TOML: Cannot overwrite a value"),
        ("m11 = 2.0", "m11 = [2.0", "pair.toml:23: not TOML: "),
    ],
)
def test_mistake_in_the_file_is_reported_by_line_and_key(
    tmp_path: Path, line: str, new: str, told: str
) -> None:
    assert told in complaint(tmp_path, changed(line, new))


@pytest.mark.parametrize(
    ("line", "new", "told"),
    [
        ("eta = [1, 0, 0]", "eta = 5", 'pair.toml:3: "leader.eta" = 5: must be an array'),
        ("eta = [1, 0, 0]", "eta = [0, 0]", 'pair.toml:3: "leader.eta" = [0, 0]: must have 3'),
        ("eta = [1, 0, 0]", 'eta = ["a", 0, 0]', "pair.toml:3: "),
        ("[boat.2]", "[boat.2.eta]\nnorth = 1\n[boat.3]", 'pair.toml:9: "boat.2.eta.north": '),
        ("duration_s = 10.0", "boat.3 = 5", 'pair.toml:1: "boat.3" = 5: must be a table'),
        ("[boat.2]", "[[boat]]", '"boat": [formation] creates the boats; use [boat.2]'),
    ],
)
def test_mistake_beside_a_formation_is_reported_by_line_and_key(
    tmp_path: Path, line: str, new: str, told: str
) -> None:
    assert SHAPED.count(line) == 1
    assert told in complaint(tmp_path, SHAPED.replace(line, new))


@pytest.mark.parametrize("key", ["eta", "nu", "input.1.surge_N"])
def test_values_that_a_route_determines_cannot_be_overridden(key: str) -> None:
    with pytest.raises(ScenarioError, match=f"^override .leader.{key}.*leader.waypoints"):
        load("square", [f"leader.{key}=[5, 0, 0]"])


SHAPED = """\
duration_s = 10.0
[leader]
eta = [1, 0, 0]
[formation]
shape = "vee"
boats = 3
spacing_m = 4.0
[boat.2]
follows = 1
"""

OVER_DIAMOND = """\
base = "diamond"
duration_s = 20
[leader.navigation]
message = "global"
[boat.2]
eta = [1, 2, 3]
[boat.2.navigation]
rate_hz = 5
[boat.3.parameters]
LAW_KX = 0.3
"""


def test_a_scenario_with_a_base_equals_the_base_except_for_its_own_keys(tmp_path: Path) -> None:
    own, diamond = load(written(tmp_path, OVER_DIAMOND)), load("diamond")
    assert (own.name, own.duration_s) == ("pair", 20)
    assert own.leader.input == diamond.leader.input
    assert own.boat[0] == diamond.boat[0]
    assert own.boat[1].eta == (1, 2, 3)
    assert own.boat[1].offset_m == diamond.boat[1].offset_m
    assert own.firmware_parameters(own.boat[2])["LAW_KX"] == 0.3
    assert load(written(tmp_path, OVER_DIAMOND), ["boat.2.eta.1=7"]).boat[1].eta == (7, 2, 3)


def test_units_have_the_boats_settings_except_for_their_own_keys(tmp_path: Path) -> None:
    own = load(written(tmp_path, OVER_DIAMOND), ["navigation.message='odometry'"])
    assert own.leader_unit() == Settings(100.0, "global")
    assert own.boat_unit(own.boat[0]) == Settings(100.0, "odometry")
    assert own.boat_unit(own.boat[1]) == Settings(5.0, "odometry")
    # The virtual leader has its own kind of message, but the rate of all units.
    slow = load("diamond", ["navigation.message='odometry'", "navigation.rate_hz=20"])
    assert slow.leader_unit() == Settings(20.0, "local")
    late = load("diamond", ["navigation.delay_s=0.2", "boat.2.navigation.timesync=false"])
    assert late.leader_unit() == Settings(100.0)
    assert late.boat_unit(late.boat[1]) == Settings(100.0, delay_s=0.2, timesync=False)


@pytest.mark.parametrize(
    ("line", "new", "told"),
    [
        ('message = "global"', 'message = "gps"', 'pair.toml:4: "leader.navigation.message" = '),
        ("eta = [1, 2, 3]", "eta = [1, 2]", '6: "boat.2.eta" = [1, 2]: must have 3 numbers'),
        ("eta = [1, 2, 3]", "follows = 2", 'pair.toml:6: "boat.2.follows" = 2: boat 2 may follow'),
        ("[boat.2]", "[boat.7]", 'pair.toml:6: no key "boat.7.eta": "7" must be a number from 1'),
        ("[boat.3.parameters]", "[boat.3.param]", '9: unknown key "boat.3.param" (did you mean'),
        ('base = "diamond"', 'base = "dimond"', 'pair.toml:1: "base": unknown scenario "dimond"'),
        ('base = "diamond"', "base = 3", 'pair.toml:1: "base": '),
        (
            'base = "diamond"',
            'base = "leader_global"',
            "that scenario has a base itself, name one without",
        ),
        (
            "rate_hz = 5",
            "rate_hz = 500",
            'pair.toml:8: "boat.2.navigation.rate_hz" = 500.0: must be at most',
        ),
        (
            "rate_hz = 5",
            'message = "follow_target"\nattitude_rate_hz = 5',
            'pair.toml:9: "boat.2.navigation.attitude_rate_hz" = 5.0: "follow_target" sends no',
        ),
        (
            'message = "global"',
            'message = "global"\norigin_m = [1, 2]',
            'pair.toml:5: "leader.navigation.origin_m" = [1.0, 2.0]: only "local" has an origin',
        ),
    ],
)
def test_mistake_over_a_base_is_reported_by_line_and_key(
    tmp_path: Path, line: str, new: str, told: str
) -> None:
    assert OVER_DIAMOND.count(f"{line}\n") == 1
    assert told in complaint(tmp_path, OVER_DIAMOND.replace(line, new))


def test_mistake_in_a_key_of_the_base_is_reported_in_the_base(tmp_path: Path) -> None:
    text = complaint(tmp_path, 'base = "diamond"\nrate_hz = 50\n')
    assert re.search(
        r'diamond\.toml:\d+: "navigation\.rate_hz" = 100\.0: must be at most rate_hz', text
    )


@pytest.mark.parametrize(
    ("override", "told"),
    [
        ("link.dely_s=1", 'unknown key "link.dely_s" (did you mean "delay_s"?)'),
        ("lnk.delay_s=1", 'unknown key "lnk" (did you mean "link"?)'),
        ("link.loss=2", '"link.loss" = 2: must be less than or equal to 1'),
        ("boat.2.eta=[0, 0]", '"boat.2.eta" = [0, 0]: must have 3 numbers'),
        ("boat.3.follows=0", 'no key "boat.3.follows": "3" must be a number from 1 to 2'),
        ("boat.2.follows=5", '"boat.2.follows" = 5: boat 2 may follow agents 0 to 1'),
        ("seed.x=1", 'no key "seed.x": 3 is not a table'),
        ("seed", "must be KEY=VALUE"),
        ("=1", "must be KEY=VALUE"),
        ("scalar=dobule", '"scalar" = "dobule": must be'),
        ("scalar=double or float", "must be KEY=VALUE, where the value is a word or TOML"),
        ("boat.2.eta=[0, 0", "must be KEY=VALUE, where the value is a word or TOML"),
        ("rate_hz=true", '"rate_hz" = true: must be'),
        ("seed=1\nrate_hz=60", "must be KEY=VALUE"),
    ],
)
def test_mistake_in_an_override_is_reported_by_the_override(
    tmp_path: Path, override: str, told: str
) -> None:
    text = complaint(tmp_path, TWO_BOATS, "link.delay_s=0.1", override)
    assert text.startswith(f'override "{override}": ') and told in text


def test_all_mistakes_are_reported_at_once(tmp_path: Path) -> None:
    text = complaint(tmp_path, changed("loss = 0.1", "loss = 2").replace("m11 = 2.0", "m11 = 0"))
    assert [line.split(": ")[0] for line in text.splitlines()] == ["pair.toml:10", "pair.toml:23"]


def test_fleet_without_boats_is_refused(tmp_path: Path) -> None:
    text = complaint(tmp_path, TWO_BOATS.split("[[boat]]", maxsplit=1)[0], "boat=[]")
    assert text.startswith('override "boat=[]"') and "at least 1" in text


def test_unknown_name_is_answered_with_the_existing_names() -> None:
    with pytest.raises(ScenarioError, match=r'unknown scenario "dimond"; did you mean "diamond"?'):
        load("dimond")


def test_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"nowhere.toml: No such file"):
        load(tmp_path / "nowhere.toml")
    (tmp_path / "latin.toml").write_bytes(b"# \xe9t\xe9")
    with pytest.raises(ScenarioError, match=r"latin.toml: not UTF-8"):
        load(tmp_path / "latin.toml")
