# SPDX-License-Identifier: MIT
"""The hulls' parameter files as ground stations and the firmware read them."""

import flotilla
import pytest
from pymavlink.mavparm import MAVParmDict

from sil.scenario import hull_files, presets


@pytest.mark.parametrize("name", presets.names())
def test_mavproxy_reads_the_parameters_that_the_hull_has(name: str) -> None:
    read = MAVParmDict()
    assert read.load(str(presets.FOLDER / f"{name}.param"))
    assert dict(read) == pytest.approx(presets.firmware(presets.load(name)))


@pytest.mark.parametrize("name", presets.names())
def test_qgroundcontrol_finds_five_columns(name: str) -> None:
    lines = hull_files.texts(name)["params"].splitlines()
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    assert all(len(row) == 5 and row[:2] == ["1", "1"] and row[4] == "9" for row in rows)
    told = {row[2]: float(row[3]) for row in rows}
    assert told == pytest.approx(presets.firmware(presets.load(name)))


@pytest.mark.parametrize("name", presets.names())
def test_the_firmware_takes_all_of_them(name: str) -> None:
    own = presets.firmware(presets.load(name))
    boat = flotilla.Boat(own, links=1, scalar="float")
    taken = boat.parameters()
    assert {key: taken[key] for key in own} == pytest.approx(own)


def test_the_papers_hull_is_the_firmwares_default() -> None:
    default = {own["name"]: own["default"] for own in flotilla.parameter_list()}
    own = presets.firmware(presets.load("paper"))
    assert own == pytest.approx({name: default[name] for name in own}, rel=1e-3)
    assert {"LAW_KDU", "LAW_KDR", "VES_M11"} <= own.keys()
