# SPDX-License-Identifier: MIT
"""flotillad's parameter file; a boat without saved parameters does not arm."""

import zlib
from collections.abc import Mapping
from pathlib import Path

import flotilla


def parameter_text(values: Mapping[str, float], *lines: str) -> str:
    """The file's content; further `lines` precede the checksum."""
    named = [f"{name} = {value:.9g}" for name, value in values.items()]
    body = "\n".join(["flotilla-parameters 1", *named, *lines]) + "\n"
    return body + f"crc32 = {zlib.crc32(body.encode()):08X}\n"


def set_up(state_dir: Path, values: Mapping[str, float]) -> None:
    """Save all parameters, defaults where `values` has none, unless the folder has some already."""
    file = state_dir / "parameters.txt"
    if file.exists() or file.with_name("parameters.txt.previous").exists():
        return
    state_dir.mkdir(parents=True, exist_ok=True)
    saved = {
        each["name"]: values.get(each["name"], each["default"])
        for each in flotilla.parameter_list()
    }
    file.write_text(parameter_text(saved), encoding="utf-8")
