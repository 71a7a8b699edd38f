# SPDX-License-Identifier: MIT
"""What of the image takes how much room: from the linker's map."""

import re
from collections import Counter
from pathlib import Path

_LIBRARIES = {
    "libm.a": "libm",
    "libgcc.a": "libgcc",
    "libc_nano.a": "libc",
    "libstdc++_nano.a": "libstdc++",
}
# The rooms' namespaces: what is optimised as a whole comes from no file of theirs.
_ROOM = re.compile(r"8flotilla\d(core|link|app|target)")
_PIECE = re.compile(r"^ (?:(\.\S+)\s+)?0x([0-9a-f]+)\s+0x([0-9a-f]+)\s+(\S.*)$")
_GAP = re.compile(r"^ \*fill\*\s+0x([0-9a-f]+)\s+0x([0-9a-f]+)")
_RAM = 0x20000000


def _room(section: str, file: str) -> str:
    if named := _ROOM.search(section):
        return named[1]
    for library, room in _LIBRARIES.items():
        if library in file:
            return room
    return "target" if "cortex_m" in file else "other"


def sizes(linker_map: Path) -> tuple[Counter[str], Counter[str]]:
    """Bytes of flash and of RAM by room. What has a first value in flash counts in both."""
    flash: Counter[str] = Counter()
    ram: Counter[str] = Counter()
    text = linker_map.read_text().split("\nLinker script and memory map\n")[1]
    # A long name has a line of its own.
    text = re.sub(r"^( \.\S+)\n\s+0x", r"\1 0x", text, flags=re.MULTILINE)
    for line in text.splitlines():
        if gap := _GAP.match(line):
            place, size, room, section = int(gap[1], 16), int(gap[2], 16), "gaps", ""
        elif (piece := _PIECE.match(line)) and piece[1]:
            section, place, size = piece[1], int(piece[2], 16), int(piece[3], 16)
            room = _room(section, piece[4])
        else:
            continue
        if section.startswith((".debug", ".comment", ".ARM.attributes", ".note")):
            continue
        if place >= _RAM:
            ram[room] += size
        if place < _RAM or section.startswith(".data"):
            flash[room] += size
    return flash, ram
