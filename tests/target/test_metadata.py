# SPDX-License-Identifier: MIT
"""The parameters' metadata for ground stations: files that the boat serves by MAVLink FTP."""

import json
import zlib
from typing import Any

import flotilla
import pytest

from tests.target.stations import float32
from tests.turns import some

FILES: dict[str, bytes] = flotilla.metadata()
LIST: list[dict[str, Any]] = flotilla.parameter_list()
DESCRIBED: list[dict[str, Any]] = json.loads(FILES["parameters.json"])["parameters"]
EACH = pytest.mark.parametrize(("entry", "p"), list(zip(DESCRIBED, LIST, strict=True)))

# parameter.schema.json of mavlink/mavlink: names and types of an entry's members
TYPES: dict[str, Any] = {
    "name": str,
    "type": str,
    "shortDesc": str,
    "units": str,
    "default": (int, float),
    "min": (int, float),
    "max": (int, float),
    "decimalPlaces": int,
    "increment": (int, float),
    "rebootRequired": bool,
    "volatile": bool,
    "group": str,
    "category": str,
    "values": list,
}


def checksum(content: bytes) -> int:
    """CRC-32 as clients compute it: initial value 0, not inverted."""
    return zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF


def test_there_is_a_general_file_and_one_of_parameters() -> None:
    assert set(FILES) == {"general.json", "parameters.json"}


def test_both_files_have_the_version_that_qgroundcontrol_insists_on() -> None:
    for content in some(FILES.values()):
        assert json.loads(content)["version"] == 1


def test_the_general_file_leads_to_the_parameters_with_the_checksum_of_the_bytes_served() -> None:
    assert json.loads(FILES["general.json"])["metadataTypes"] == [
        {
            "type": 1,
            "uri": "mftp:///parameters.json",
            "fileCrc": checksum(FILES["parameters.json"]),
        }
    ]


@EACH
def test_an_entry_has_the_parameters_name_sentence_unit_and_range(
    entry: dict[str, Any], p: dict[str, Any]
) -> None:
    assert entry["name"] == p["name"]
    assert entry["type"] == "Float"
    assert entry["shortDesc"] == p["sentence"]
    assert entry["units"] == p["unit"]
    assert entry["group"]
    assert entry["category"] == "Standard"
    for key, name in {"default": "default", "min": "least", "max": "greatest"}.items():
        assert float32(entry[key]) == p[name]


@pytest.mark.parametrize("entry", DESCRIBED)
def test_an_entry_has_only_keys_and_types_of_the_schema(entry: dict[str, Any]) -> None:
    for key, value in some(entry.items()):
        assert isinstance(value, TYPES[key]), key
    for choice in entry.get("values", []):
        assert isinstance(choice["value"], int)
        assert isinstance(choice["description"], str)
        assert set(choice) == {"value", "description"}


@EACH
def test_a_ground_station_shows_default_and_range_in_full(
    entry: dict[str, Any], p: dict[str, Any]
) -> None:
    places = entry["decimalPlaces"]
    for key in ("default", "min", "max"):
        assert round(entry[key], places) == entry[key]
    assert (places == 0) == p["integer"]


def test_choices_are_offered_where_only_some_values_are_taken() -> None:
    choices = {entry["name"]: entry["values"] for entry in DESCRIBED if "values" in entry}
    direction = [
        {"value": -1, "description": "reversed"},
        {"value": 1, "description": "normal"},
    ]
    action = [
        {"value": 0, "description": "HOLD"},
        {"value": 1, "description": "COAST, then FS_COAST_ACT"},
        {"value": 2, "description": "MANUAL with fresh sticks"},
        {"value": 3, "description": "LOITER"},
        {"value": 4, "description": "RTL"},
    ]
    stop = [
        {"value": 0, "description": "HOLD"},
        {"value": 1, "description": "LOITER"},
        {"value": 2, "description": "RTL"},
    ]
    assert choices == {
        "RTL_ALONE": [{"value": 0, "description": "off"}, {"value": 1, "description": "on"}],
        "FS_LEADER_ACT": action,
        "FS_GCS_ACT": action,
        "FS_COAST_ACT": stop,
        "FS_BATT_ACT": stop,
        "FS_FENCE_ACT": stop,
        "MAV_IDENTITY": [
            {"value": 0, "description": "vehicle"},
            {"value": 1, "description": "companion"},
        ],
        "MAV_AUTOPILOT": [
            {"value": 0, "description": "GENERIC"},
            {"value": 1, "description": "ARDUPILOTMEGA"},
        ],
        "FORM_FRAME": [
            {"value": 0, "description": "north-east"},
            {"value": 1, "description": "ahead-starboard"},
        ],
        "LAW_REF": [
            {"value": 0, "description": "off"},
            {"value": 1, "description": "on"},
        ],
        "THR_PORT_DIR": direction,
        "THR_STBD_DIR": direction,
    }


def test_parameters_in_force_at_the_next_start_are_marked_reboot_required() -> None:
    restart = {entry["name"] for entry in DESCRIBED if entry["rebootRequired"]}
    identity = {"MAV_SYSID", "MAV_COMPID", "MAV_IDENTITY", "MAV_AUTOPILOT"}
    assert {*identity, "CAN_NODE", "CTL_RATE"} == restart
