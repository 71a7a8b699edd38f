# SPDX-License-Identifier: MIT
"""The hulls' parameter files as ground stations and the firmware read them."""

from pathlib import Path

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink
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
    default = flotilla.derived({own["name"]: own["default"] for own in flotilla.parameter_list()})
    own = presets.firmware(presets.load("paper"))
    assert own.pop("THR_LAG") == 0.0  # unknown by default, which for a boat of 1 kg is none
    own = {name: flotilla.derived(own)[name] for name in own}
    assert own == pytest.approx({name: default[name] for name in own}, rel=1e-3)
    assert {"LAW_KDU", "LAW_KDR", "VES_M11"} <= own.keys()


@pytest.mark.parametrize("name", presets.names())
def test_a_ground_station_may_send_them_in_the_files_order(name: str) -> None:
    boat = flotilla.Boat({"MAV_SYSID": 1.0}, links=1, scalar="float")
    station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    own = presets.firmware(presets.load(name))
    for k, (parameter, value) in enumerate(own.items(), start=1):
        message = station.param_set_encode(1, 1, parameter.encode(), value, 9)
        boat.on_mavlink(bytes(message.pack(station)), 100_000 * k, link=0)
        boat.tick(100_000 * k)
        assert boat.parameters()[parameter] == pytest.approx(value, rel=1e-6)


def test_the_file_of_a_hull_of_ones_own_names_where_it_is_from(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    text = presets.path_of("paper").read_text(encoding="utf-8")
    path.write_text(text.partition("\n\n")[2], encoding="utf-8")
    lines = hull_files.texts(str(path))["param"].splitlines()
    assert lines[0] == f"# {path}" and lines[1].endswith(f"by flotilla hulls from {path}")
