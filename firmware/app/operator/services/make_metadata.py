# SPDX-License-Identifier: MIT
"""Writes a boat's component metadata, JSON files made of parameters.def, as a C++ header.

The long one is packed: link/mavlink/packed_text.hpp reads it.

make_metadata.py PARAMETERS_DEF HEADER
"""

import json
import re
import sys
import zlib
from collections.abc import Iterable
from pathlib import Path

from byte_pairs import Packed, pack

TEXT = r'"([^"\\]*)", '
PARAMETER = re.compile(
    rf"FLOTILLA_PARAMETER\({TEXT}(\w+), {TEXT}(\S+), (\S+), (\S+), (\w+), (\w+), " r'"([^"\\]*)"\)'
)
WHOLE: dict[str, object] = {"decimalPlaces": 0}
KINDS = {"Real": {"decimalPlaces": 4}, "Whole": WHOLE | {"increment": 1}} | {
    kind: WHOLE
    | {"values": [{"value": number, "description": text} for number, text in values.items()]}
    for kind, values in {
        "Sign": {-1: "reversed", 1: "normal"},
        "Identity": {0: "vehicle", 1: "companion"},
        "Autopilot": {0: "GENERIC", 1: "ARDUPILOTMEGA"},
        "Frame": {0: "north-east", 1: "ahead-starboard"},
        "Switch": {0: "off", 1: "on"},
        "Action": {
            0: "HOLD",
            1: "COAST, then FS_COAST_ACT",
            2: "MANUAL with fresh sticks",
            3: "LOITER",
            4: "RTL",
        },
        "Stop": {0: "HOLD", 1: "LOITER", 2: "RTL"},
    }.items()
}
CHANGES = {
    "Anytime": {"rebootRequired": False},
    "Disarmed": {"rebootRequired": False},
    "Restart": {"rebootRequired": True},
}


def described(line: str) -> dict[str, object]:
    """One parameter, as in version 1 of the schema, which QGroundControl requires."""
    parts = PARAMETER.fullmatch(line)
    if parts is None:
        sys.exit(f"parameters.def: not one whole parameter without escapes: {line}")
    group, name, unit, value, least, greatest, kind, change, sentence = parts.groups()
    return {
        "name": name,
        "type": "Float",
        "shortDesc": sentence,
        "units": unit,
        "default": json.loads(value),
        "min": json.loads(least),
        "max": json.loads(greatest),
        **KINDS[kind],
        **CHANGES[change],
        "group": group,
        "category": "Standard",
    }


def crc(text: str) -> int:
    """CRC-32 as MAVLink uses it: begins with 0, not inverted at the end."""
    return zlib.crc32(text.encode(), 0xFFFFFFFF) ^ 0xFFFFFFFF


def compact(document: object) -> str:
    """JSON without blanks."""
    return json.dumps(document, ensure_ascii=False, separators=(",", ":"))


def numbers(values: Iterable[int]) -> str:
    """As the elements of an initialiser."""
    return ", ".join(map(str, values))


def literal(packed: Packed, size: int, checksum: int) -> str:
    """The packed text as C++ constants."""
    pairs = (f"{{{{{numbers(pair)}}}}}" for pair in packed.pairs)
    return (
        f"constexpr auto kBytes = std::to_array<std::uint8_t>({{{numbers(packed.data)}}});\n"
        f"constexpr auto kPages = std::to_array<std::uint16_t>({{{numbers(packed.pages)}}});\n"
        f"constexpr link::PackedText::Pairs kPairs{{{{{', '.join(pairs)}}}}};\n"
        "constexpr link::PackedText::Packed kParameters"
        f"{{kBytes, kPages, &kPairs, {size}, {checksum}U}};\n"
    )


lines = Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()
entries = [described(line) for line in lines if line and not line.startswith("//")]
parameters = compact({"version": 1, "parameters": entries})
file = {"type": 1, "uri": "mftp:///parameters.json", "fileCrc": crc(parameters)}
general = compact({"version": 1, "metadataTypes": [file]})
Path(sys.argv[2]).write_text(
    "// Made by make_metadata.py\n#pragma once\n\n#include <array>\n#include <string_view>\n\n"
    '#include "link/mavlink/packed_text.hpp"\n\n'
    "namespace flotilla::app {\n"
    f'constexpr std::string_view kGeneralJson = R"json({general})json";\n'
    f"{literal(pack(parameters.encode()), len(parameters.encode()), crc(parameters))}"
    "}  // namespace flotilla::app\n",
    encoding="utf-8",
)
