# SPDX-License-Identifier: MIT
"""Makes the C++ of the messages in messages.txt, and the table of the dialect's.

generate.py FOLDER: writes messages.hpp and table.inc there. pymavlink parses the dialect:
flotilla.xml and what it includes, of the installed pymavlink.
"""

import contextlib
import io
import sys
from pathlib import Path
from typing import Any, NamedTuple

import pymavlink
from pymavlink.generator import mavparse

HERE = Path(__file__).parent
WHEEL = Path(pymavlink.__file__).parent / "dialects" / "v20"
# Extensions that upstream's common.xml has and the wheel's lacks.
NEWER = {"TIMESYNC": ["target_system", "target_component"]}
NO_TARGET = 255  # an offset that no payload reaches
TARGET = ["target_system", "target_component"]


class Member(NamedTuple):
    """A member of a struct; `places`: offset in the payload and expression of each of its parts."""

    type: str
    name: str
    places: list[tuple[int, str]]
    extension: bool
    unit: str


class Message(NamedTuple):
    """A message of the list: the dialect's definition, its struct, and `constants` that are sent."""

    wire: Any
    struct: str
    is_read: bool
    members: list[Member]
    constants: list[tuple[int, str]]


def dialect(path: Path = HERE / "flotilla.xml") -> dict[str, Any]:
    """Every message of the dialect by name, as mavparse has it."""
    with contextlib.redirect_stdout(io.StringIO()):  # it comments on enums
        xml = mavparse.MAVXML(str(path), mavparse.PROTOCOL_2_0)
    messages = {message.name: message for message in xml.message}
    for message in messages.values():
        for name in NEWER.get(message.name, []):
            field = mavparse.MAVField(name, "uint8_t", None, xml)
            field.wire_offset = message.wire_length
            message.extensions_start = message.base_fields()
            message.fields.append(field)
            message.wire_length += field.wire_length
    for included in xml.include:
        messages |= dialect(WHEEL / included)
    return messages


def cpp_type(field: Any) -> str:
    """The type of one element."""
    return field.type if field.type in {"char", "float", "double"} else f"std::{field.type}"


def array_of(field: Any, count: int) -> str:
    return f"Text<{count}>" if field.type == "char" else f"std::array<{cpp_type(field)}, {count}>"


def member(wire: Any, name: str, fields: list[Any]) -> Member:
    first = fields[0]
    if name == "target" and len(fields) > 1:
        type_ = "Address"
        parts = ["target.system", "target.component"]
        places = [(f.wire_offset, part) for f, part in zip(fields, parts, strict=True)]
    else:
        offsets = [first.wire_offset + k * first.wire_length for k in range(len(fields))]
        if offsets != [f.wire_offset for f in fields] or len({f.type for f in fields}) > 1:
            sys.exit(f"{wire.name}: {name}: only neighbours of one type make an array")
        count = first.array_length or (len(fields) if len(fields) > 1 else 0)
        type_ = array_of(first, count) if count else cpp_type(first)
        places = [(first.wire_offset, name)]
    extension = wire.fields.index(first) >= wire.base_fields()
    return Member(type_, name, places, extension, first.units.strip("[]"))


def constant(field: Any, value: str) -> tuple[int, str]:
    number = "std::numeric_limits<float>::quiet_NaN()" if value == "nan" else value
    return field.wire_offset, f"{cpp_type(field)}{{{number}}}"


def message(line: str, messages: dict[str, Any]) -> Message:
    """One line of the list."""
    name, direction, *items = line.split()
    name, _, struct = name.partition(":")
    if name not in messages or direction not in {"read", "send"}:
        sys.exit(f"{line}: no such message, or neither read nor send")
    wire = messages[name]
    fields = {field.name: field for field in wire.fields}
    if not items:
        items = ["target" if f == TARGET[0] else f for f in fields if f != TARGET[1]]
    if "target" not in fields:
        items = ["target=" + ",".join(TARGET) if item == "target" else item for item in items]
    members, constants = [], []
    for item in items:
        own, _, source = item.partition("=")
        parts = (source or own).split(",")
        if all(part in fields for part in parts):
            members.append(member(wire, own, [fields[part] for part in parts]))
        elif source and own in fields:
            constants.append(constant(fields[own], source))
        else:
            sys.exit(f"{name}: it has no field {item}")
    struct = struct or "".join(word.capitalize() for word in name.split("_"))
    return Message(wire, struct, direction == "read", members, constants)


def listed(messages: dict[str, Any], text: str) -> list[Message]:
    lines = [line for line in text.replace("\n ", " ").splitlines() if line.strip()]
    return [message(line, messages) for line in lines if not line.startswith("#")]


def calls(function: str, places: list[tuple[int, str]]) -> str:
    return "".join(f"    {function}({offset}, {expression});\n" for offset, expression in places)


def struct_of(m: Message) -> str:
    members = "".join(
        f"  {x.type} {x.name}{'{}' if x.extension else ''};"
        + (f"  ///< {x.unit}\n" if x.unit else "\n")
        for x in m.members
    )
    out = (
        f"struct {m.struct} {{\n{members}\n"
        f"  static constexpr std::uint16_t kId{{{m.wire.id}}};\n"
        f"  static constexpr std::uint8_t kCrcExtra = {m.wire.crc_extra};\n"
        f"  static constexpr std::size_t kBytes = {m.wire.wire_length};\n"
        f"  static constexpr bool kIsRead = {str(m.is_read).lower()};\n"
        "  static void fields(auto& x, auto field) {\n"
        + calls("field", [(offset, "x." + part) for y in m.members for offset, part in y.places])
        + "  }\n"
    )
    if m.constants:
        out += "  static void constants(auto put) {\n" + calls("put", m.constants) + "  }\n"
    return out + "};\n\n"


def messages_hpp(messages: list[Message]) -> str:
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
        f"namespace flotilla::link {{\n\n{''.join(map(struct_of, messages))}"
        f"using Message = std::variant<{kinds}>;\n\n"
        "/// Calls read<Struct>() of the message with this id; of std::monostate if boats read none.\n"
        "decltype(auto) with_struct(std::uint32_t id, auto read) {\n"
        f"  switch (id) {{\n{cases}"
        "    default:\n      return read.template operator()<std::monostate>();\n  }\n}\n\n"
        "}  // namespace flotilla::link\n"
    )


def entry(wire: Any) -> str:
    offsets = {field.name: field.wire_offset for field in wire.fields}
    if wire.name == "MANUAL_CONTROL":
        offsets[TARGET[0]] = offsets["target"]
    targets = [offsets.get(name, NO_TARGET) for name in TARGET]
    numbers = [wire.id, wire.crc_extra, wire.wire_min_length, *targets]
    return f"{{{', '.join(map(str, numbers))}}},\n"


def table_inc(wires: list[Any]) -> str:
    """A MavlinkEntry of every message of the dialect, by rising id."""
    return "".join(map(entry, sorted(wires, key=lambda wire: wire.id)))


if __name__ == "__main__":
    wires = dialect()
    messages = listed(wires, (HERE / "messages.txt").read_text(encoding="utf-8"))
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "messages.hpp").write_text(messages_hpp(messages), encoding="utf-8")
    (folder / "table.inc").write_text(table_inc(list(wires.values())), encoding="utf-8")
