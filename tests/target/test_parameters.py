# SPDX-License-Identifier: MIT
"""Parameters as an operator sees them: names, ranges, refusals with reasons."""

import math
import re
from typing import Any

import flotilla
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.target.sea import seeded
from tests.target.stations import float32
from tests.turns import some

LIST: list[dict[str, Any]] = flotilla.parameter_list()
BY_NAME = {p["name"]: p for p in LIST}
EACH = pytest.mark.parametrize("p", LIST, ids=list(BY_NAME))

DESIGN_NAMES = [
    "MAV_SYSID",
    "MAV_COMPID",
    "MAV_IDENTITY",
    "MAV_AUTOPILOT",
    "MAV_GCS_SYSID",
    "FORM_LEADER",
    "FORM_OFS_N",
    "FORM_OFS_E",
    "FORM_FRAME",
    "LAW_KX",
    "LAW_KPSI",
    "LAW_KDU",
    "LAW_KDR",
    "LAW_OBS_BW",
    "LAW_XT_DIST",
    "LAW_CUR_BW",
    "LAW_U_MAX",
    "LAW_R_MAX",
    "LAW_REF",
    "VES_M11",
    "VES_M22",
    "VES_M33",
    "VES_D11",
    "VES_D22",
    "VES_D33",
    "THR_ARM",
    "THR_FWD_MAX",
    "THR_REV_MAX",
    "THR_EXPO",
    "THR_DEAD",
    "THR_SLEW",
    "THR_PORT_DIR",
    "THR_STBD_DIR",
    "ESC_PORT",
    "ESC_STBD",
    "CAN_NODE",
    "CTL_RATE",
    "NAV_OFS_X",
    "NAV_OFS_Y",
    "SR_STATE",
    "FS_LEADER_S",
    "FS_NAV_S",
    "FS_ESC_S",
]

# Pairs of values that exclude each other though each is allowed by itself.
CONTRADICTIONS = [
    ({"ESC_PORT": 3, "ESC_STBD": 3}, "ESC_PORT", "ESC_STBD"),
    ({"MAV_SYSID": 7, "FORM_LEADER": 7}, "MAV_SYSID", "FORM_LEADER"),
    ({"MAV_IDENTITY": 1, "MAV_COMPID": 1}, "MAV_IDENTITY", "MAV_COMPID"),
]


def a_valid_value(p: dict[str, Any], fraction: float) -> float:
    value = p["least"] + fraction * (p["greatest"] - p["least"])
    if p["integer"]:
        return float(round(value))
    return min(max(float32(value), p["least"]), p["greatest"])


HOLD = 4.0


def other_names_kept_apart(name: str, value: float) -> dict[str, float]:
    """The value, with its partner changed if the two must differ."""
    if name == "MAV_IDENTITY":
        return {name: value, "MAV_COMPID": 191.0}
    partner = {
        "ESC_PORT": "ESC_STBD",
        "ESC_STBD": "ESC_PORT",
        "MAV_SYSID": "FORM_LEADER",
        "FORM_LEADER": "MAV_SYSID",
    }
    chosen = {name: value}
    if name in partner:
        chosen[partner[name]] = value - 1 if value > 1 else value + 1
    return chosen


def refusal(parameters: dict[Any, Any]) -> str:
    with pytest.raises(ValueError) as refused:  # noqa: PT011 (callers look at what it says)
        flotilla.Boat(parameters)
    return str(refused.value)


def test_every_parameter_that_the_design_names_exists() -> None:
    assert set(DESIGN_NAMES) <= set(BY_NAME)


def test_names_are_unique_and_fit_into_mavlink() -> None:
    assert len(BY_NAME) == len(LIST)
    for name in some(BY_NAME):
        assert re.fullmatch(r"[A-Z][A-Z0-9]*(_[A-Z0-9]+)*", name) and len(name) <= 16, name


@EACH
def test_every_parameter_has_a_unit_a_range_and_one_sentence(p: dict[str, Any]) -> None:
    numbers = {"default", "least", "greatest"}
    assert set(p) == {"name", "unit", "group", "kind", "integer", "change", "sentence"} | numbers
    assert isinstance(p["unit"], str)
    assert re.fullmatch(r"[A-Z0-9].{8,}\.", p["sentence"]), p["sentence"]
    assert all(math.isfinite(p[key]) for key in ("default", "least", "greatest"))
    assert p["least"] < p["greatest"]


@EACH
def test_every_parameter_has_a_kind_and_a_time_of_change(p: dict[str, Any]) -> None:
    choices = ("identity", "autopilot", "frame", "switch", "action", "stop")
    assert p["kind"] in ("real", "whole", "sign", *choices)
    assert (p["kind"] == "autopilot") == (p["name"] == "MAV_AUTOPILOT")
    assert p["integer"] == (p["kind"] != "real")
    assert p["change"] in ("anytime", "disarmed", "restart")
    assert (p["kind"] == "sign") == p["name"].endswith("_DIR")
    assert (p["kind"] in ("action", "stop")) == p["name"].endswith("_ACT")
    assert (p["kind"] == "frame") == (p["name"] == "FORM_FRAME")
    assert (p["kind"] == "switch") == (p["name"] in ("LAW_REF", "RTL_ALONE"))
    assert re.fullmatch(r"[A-Z][A-Za-z]+", p["group"])


def test_tuning_parameters_may_change_under_way_and_vessel_parameters_may_not() -> None:
    anytime = {p["name"] for p in LIST if p["change"] == "anytime"}
    assert {"LAW_KX", "LAW_KPSI", "FORM_OFS_N", "FORM_OFS_E"} <= anytime
    assert not any(n.startswith(("VES_", "THR_", "ESC_", "FS_", "CAN_", "MAV_")) for n in anytime)


def test_only_numbers_without_dimension_lack_a_unit() -> None:
    dimensionless = {p["name"] for p in LIST if not p["unit"]}
    assert all(
        BY_NAME[n]["integer"] or n in {"THR_EXPO", "THR_BALANCE", "NAV_HDOP", "NAV_VAR"}
        for n in some(dimensionless)
    ), dimensionless


@EACH
def test_a_default_lies_within_its_range(p: dict[str, Any]) -> None:
    assert p["least"] <= p["default"] <= p["greatest"]
    if p["integer"]:
        assert p["default"] == int(p["default"])


@EACH
def test_every_number_travels_as_real32_without_loss(p: dict[str, Any]) -> None:
    for key in ("default", "least", "greatest"):
        assert float32(p[key]) == p[key]


def test_a_boat_without_parameters_has_the_defaults() -> None:
    assert flotilla.Boat().parameters() == {p["name"]: p["default"] for p in LIST}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("FS_LEADER_S", 1.0),
        ("FS_NAV_S", 0.5),
        ("FS_ESC_S", 1.2),
        ("MAV_COMPID", 1.0),
        ("MAV_GCS_SYSID", 0.0),
        ("CTL_RATE", 100.0),
    ],
)
def test_a_default_is_the_designs(name: str, value: float) -> None:
    assert BY_NAME[name]["default"] == pytest.approx(value)


def test_the_control_rate_is_at_least_50_hz() -> None:
    assert BY_NAME["CTL_RATE"]["least"] >= 50.0


@EACH
@pytest.mark.parametrize("end", ["least", "greatest"])
def test_both_ends_of_a_range_are_allowed(p: dict[str, Any], end: str) -> None:
    roomy = {"THR_FWD_MAX": 1e5, "THR_REV_MAX": 1e5} if p["name"] == "THR_DEAD" else {}
    given_values = roomy | other_names_kept_apart(p["name"], p[end])
    boat = flotilla.Boat(given_values)
    assert boat.parameters()[p["name"]] == p[end]


@EACH
@pytest.mark.parametrize("end", ["least", "greatest"])
def test_a_value_beyond_its_range_is_refused_with_name_and_range(
    p: dict[str, Any], end: str
) -> None:
    sign = -1.0 if end == "least" else 1.0
    for step in (1.0 if p["integer"] else max(abs(p[end]) * 1e-5, 1e-6), 1e6, 1e30, 1e39, 1e300):
        said = refusal({p["name"]: p[end] + sign * step})
        assert p["name"] in said
        numbers = [
            float(n)
            for n in re.findall(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?", said.replace(p["name"], ""))
        ]
        for bound in (p["least"], p["greatest"]):
            assert any(math.isclose(n, bound, rel_tol=1e-4, abs_tol=1e-9) for n in numbers), said


@EACH
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf], ids=["nan", "inf", "-inf"])
def test_a_nan_or_infinite_value_is_refused_by_name(p: dict[str, Any], value: float) -> None:
    assert p["name"] in refusal({p["name"]: value})


@pytest.mark.parametrize("name", [p["name"] for p in LIST if p["integer"]])
def test_a_fraction_of_an_integer_is_refused_by_name(name: str) -> None:
    p = BY_NAME[name]
    assert name in refusal({name: (p["least"] + p["greatest"]) / 2 + 0.25})


@pytest.mark.parametrize("name", [n for n in BY_NAME if n.endswith("_DIR")])
def test_a_propeller_without_direction_is_refused(name: str) -> None:
    assert name in refusal({name: 0.0})


@pytest.mark.parametrize(
    "value", ["2", b"2", None, [2], {}, object()], ids=lambda v: type(v).__name__
)
def test_a_value_of_another_type_is_refused_by_name(value: object) -> None:
    assert "MAV_SYSID" in refusal({"MAV_SYSID": value})


@pytest.mark.parametrize(
    "name", ["", "MAV_SYSI", "MAV_SYSID ", "mav_sysid", "MAV_SYSIDX", "X" * 200, "ÄÖ", "LAW_KX\0"]
)
def test_an_unknown_name_is_refused_by_name(name: str) -> None:
    assert name.rstrip("\0") in refusal({name: 1.0})


def test_a_key_that_is_no_text_is_refused() -> None:
    with pytest.raises(TypeError, match="name must be a string"):
        flotilla.Boat({3: 1.0})


@pytest.mark.parametrize(("parameters", "one", "other"), CONTRADICTIONS)
def test_a_contradiction_is_refused_by_both_names(
    parameters: dict[str, float], one: str, other: str
) -> None:
    said = refusal(parameters)
    assert one in said and other in said


def test_a_contradiction_with_a_default_is_refused() -> None:
    assert "ESC_PORT" in refusal({"ESC_PORT": BY_NAME["ESC_STBD"]["default"]})
    assert "FORM_LEADER" in refusal({"MAV_SYSID": BY_NAME["FORM_LEADER"]["default"]})


def test_one_wrong_value_among_right_ones_is_the_one_named() -> None:
    said = refusal({"MAV_SYSID": 2, "FORM_LEADER": 1, "LAW_KX": -1.0, "SR_STATE": 5})
    assert "LAW_KX" in said
    assert not any(name in said for name in ("MAV_SYSID", "FORM_LEADER", "SR_STATE"))


def test_whole_numbers_and_booleans_are_accepted() -> None:
    assert flotilla.Boat({"MAV_SYSID": 2}).parameters()["MAV_SYSID"] == 2.0
    assert flotilla.Boat({"THR_PORT_DIR": True}).parameters()["THR_PORT_DIR"] == 1.0


@seeded()
@given(st.lists(st.floats(0.0, 1.0), min_size=len(LIST), max_size=len(LIST)))
def test_parameters_come_back_as_they_were_given(fractions: list[float]) -> None:
    given_values = {p["name"]: a_valid_value(p, f) for p, f in zip(LIST, fractions, strict=True)}
    given_values |= {"ESC_PORT": 2.0, "ESC_STBD": 5.0, "MAV_SYSID": 9.0, "FORM_LEADER": 8.0}
    given_values |= {"MAV_IDENTITY": 1.0, "MAV_COMPID": 191.0}
    given_values |= {"THR_PORT_DIR": -1.0, "THR_STBD_DIR": 1.0, "THR_DEAD": 0.03125}
    boat = flotilla.Boat(given_values)
    assert boat.parameters() == given_values
    assert flotilla.Boat(boat.parameters()).parameters() == given_values


def test_parameters_is_a_copy_and_does_not_change_the_boat() -> None:
    boat = flotilla.Boat()
    boat.parameters()["LAW_KX"] = 99.0
    assert boat.parameters()["LAW_KX"] == BY_NAME["LAW_KX"]["default"]


@pytest.mark.parametrize("links", [1, 2, 3, 4])
def test_a_boat_sends_on_each_of_its_one_to_four_links(links: int) -> None:
    assert {link for link, _ in flotilla.Boat({}, links).tick(0).mavlink} == set(range(links))


@pytest.mark.parametrize("links", [-1, 0, 5, 1000, 2**31 - 1])
def test_another_number_of_links_is_refused(links: int) -> None:
    with pytest.raises(ValueError, match="links: a whole number from 1 to 4"):
        flotilla.Boat({}, links)


@pytest.mark.parametrize("scalar", ["", "Float", "half", "float32"])
def test_an_unknown_scalar_is_refused(scalar: str) -> None:
    with pytest.raises(ValueError, match=r"(?i)scalar|float"):
        flotilla.Boat({}, 1, scalar)


@pytest.mark.parametrize("link", [-1, 1, 4, 255, 2**31 - 1])
def test_bytes_on_a_link_that_does_not_exist_are_refused(link: int) -> None:
    with pytest.raises(ValueError, match="link: from 0 to 0"):
        flotilla.Boat({}, 1).on_mavlink(b"", 0, link)
