# SPDX-License-Identifier: MIT
"""Generates the C++ structs of the messages in messages.txt, and the table of all messages.

generate.py FOLDER: writes messages.hpp and table.inc there. pymavlink parses the dialect:
flotilla.xml, and the files that it includes from the installed pymavlink.
"""

import contextlib
import io
import sys
from itertools import accumulate
from operator import or_
from pathlib import Path
from typing import Any, NamedTuple

import pymavlink
from pymavlink.generator import mavparse

HERE = Path(__file__).parent
WHEEL = Path(pymavlink.__file__).parent / "dialects" / "v20"
# Extension fields in upstream's common.xml that the wheel's lacks.
NEWER = {
    "TIMESYNC": {"target_system": "uint8_t", "target_component": "uint8_t"},
    "MISSION_COUNT": {"opaque_id": "uint32_t"},
    "MISSION_ACK": {"opaque_id": "uint32_t"},
    "MISSION_CURRENT": {
        "mission_id": "uint32_t",
        "fence_id": "uint32_t",
        "rally_points_id": "uint32_t",
    },
}
NO_TARGET = 255  # an offset beyond any payload
TARGET = ["target_system", "target_component"]


Place = tuple[int, str]  # offset in the payload, C++ expression


class Member(NamedTuple):
    """A member of a struct; `places`: its place on the wire, or that of each of its parts."""

    type: str
    name: str
    places: list[Place]
    extension: bool
    unit: str


class Message(NamedTuple):
    """A line of the list: the dialect's message, the struct, and the `constants` that are sent."""

    wire: Any
    struct: str
    is_read: bool
    members: list[Member]
    constants: list[Place]


def dialect(path: Path = HERE / "flotilla.xml") -> dict[str, Any]:
    """Every message of the dialect by name, as mavparse returns it."""
    with contextlib.redirect_stdout(io.StringIO()):  # it comments on enums
        xml = mavparse.MAVXML(str(path), mavparse.PROTOCOL_2_0)
    messages = {message.name: message for message in xml.message}
    for message in messages.values():
        for name, type_ in NEWER.get(message.name, {}).items():
            field = mavparse.MAVField(name, type_, None, xml)
            field.wire_offset = message.wire_length
            if message.extensions_start is None:
                message.extensions_start = len(message.fields)
            message.fields.append(field)
            message.wire_length += field.wire_length
    for included in xml.include:
        messages |= dialect(WHEEL / included)
    return messages


def _element(field: Any) -> str:
    return field.type if field.type in {"char", "float", "double"} else f"std::{field.type}"


def _member(wire: Any, name: str, fields: list[Any]) -> Member:
    first, element = fields[0], _element(fields[0])
    parts = [f.name for f in fields]
    if parts == TARGET:
        type_ = "Address"
        places = [(f.wire_offset, f"target.{f.name.removeprefix('target_')}") for f in fields]
    else:
        neighbours = [first.wire_offset + k * first.wire_length for k in range(len(fields))]
        if neighbours != [f.wire_offset for f in fields] or len({f.type for f in fields}) > 1:
            raise ValueError(f"{wire.name}: only neighbours of one type make an array: {parts}")
        count = first.array_length or len(fields)
        many = f"Text<{count}>" if element == "char" else f"std::array<{element}, {count}>"
        type_ = many if first.array_length or len(fields) > 1 else element
        places = [(first.wire_offset, name)]
    extension = wire.fields.index(first) >= wire.base_fields()
    return Member(type_, name, places, extension, first.units.strip("[]"))


def _message(line: str, dialect: dict[str, Any]) -> Message:
    head, direction, *items = line.split()
    name, _, struct = head.partition(":")
    if name not in dialect or direction not in {"read", "send"}:
        raise ValueError(f"{line}: no such message, or neither read nor send")
    wire = dialect[name]
    fields = {field.name: field for field in wire.fields}
    items = items or ["target" if f == TARGET[0] else f for f in fields if f != TARGET[1]]
    members, constants = [], []
    for item in items:
        own, _, source = item.partition("=")
        parts = (source or own).split(",")
        if item == "target" and "target" not in fields:
            parts = TARGET
        if all(part in fields for part in parts):
            members.append(_member(wire, own, [fields[part] for part in parts]))
        elif source and own in fields:
            number = "std::numeric_limits<float>::quiet_NaN()" if source == "nan" else source
            constants.append((fields[own].wire_offset, f"{_element(fields[own])}{{{number}}}"))
        else:
            raise ValueError(f"{name}: it has no field {item}")
    struct = struct or "".join(word.capitalize() for word in name.split("_"))
    return Message(wire, struct, direction == "read", members, constants)


def listed(text: str, dialect: dict[str, Any]) -> list[Message]:
    """The messages of a list; ValueError if a line is wrong."""
    lines = text.replace("\n ", " ").splitlines()
    return [_message(line, dialect) for line in lines if line.strip() and line[0] != "#"]


def _calls(function: str, places: list[Place]) -> str:
    return "".join(f"    {function}({offset}, {expression});\n" for offset, expression in places)


def _struct(m: Message) -> str:
    defaults = accumulate((x.extension for x in m.members), or_)  # from the first extension on
    members = "".join(
        f"  {x.type} {x.name}{'{}' * default};{f'  ///< {x.unit}' if x.unit else ''}\n"
        for x, default in zip(m.members, defaults, strict=True)
    )
    places = [(offset, f"x.{part}") for x in m.members for offset, part in x.places]
    constants = f"  static void constants(auto put) {{\n{_calls('put', m.constants)}  }}\n"
    return (
        f"struct {m.struct} {{\n{members}\n"
        f"  static constexpr std::uint16_t kId{{{m.wire.id}}};\n"
        f"  static constexpr std::uint8_t kCrcExtra{{{m.wire.crc_extra}}};\n"
        f"  static constexpr std::size_t kBytes{{{m.wire.wire_length}}};\n"
        f"  static constexpr bool kIsRead{{{str(m.is_read).lower()}}};\n"
        f"  static void fields(auto& x, auto field) {{\n{_calls('field', places)}  }}\n"
        f"{constants if m.constants else ''}}};\n\n"
    )


def messages_hpp(messages: list[Message]) -> str:
    """The structs; each defines its members' places on the wire, and the constants it sends."""
    kinds = ", ".join(["std::monostate", *(m.struct for m in messages)])
    cases = "".join(
        f"    case {m.wire.id}:\n      return read.template operator()<{m.struct}>();\n"
        for m in messages
        if m.is_read
    )
    return (
        "// Generated by firmware/link/mavlink/generate.py\n#pragma once\n\n"
        "#include <array>\n#include <cstddef>\n#include <cstdint>\n#include <limits>\n"
        '#include <variant>\n\n#include "link/mavlink/address.hpp"\n\n'
        f"namespace flotilla::link {{\n\n{''.join(map(_struct, messages))}"
        f"using Message = std::variant<{kinds}>;\n\n"
        "/// Calls read<Struct>() of the message with this id, or of std::monostate.\n"
        "void with_struct(std::uint32_t id, auto read) {\n"
        f"  switch (id) {{\n{cases}"
        "    default:\n      return read.template operator()<std::monostate>();\n  }\n}\n\n"
        "}  // namespace flotilla::link\n"
    )


def table_inc(dialect: dict[str, Any]) -> str:
    """A MavlinkEntry of every message of the dialect, by rising id."""
    out = ""
    for wire in sorted(dialect.values(), key=lambda wire: wire.id):
        offsets = {field.name: field.wire_offset for field in wire.fields}
        if wire.name == "MANUAL_CONTROL":
            offsets[TARGET[0]] = offsets["target"]
        targets = [offsets.get(name, NO_TARGET) for name in TARGET]
        numbers = [wire.id, wire.crc_extra, wire.wire_min_length, *targets]
        out += f"{{{', '.join(map(str, numbers))}}},\n"
    return out


if __name__ == "__main__":
    known = dialect()
    messages = listed((HERE / "messages.txt").read_text(encoding="utf-8"), known)
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "messages.hpp").write_text(messages_hpp(messages), encoding="utf-8")
    (folder / "table.inc").write_text(table_inc(known), encoding="utf-8")
