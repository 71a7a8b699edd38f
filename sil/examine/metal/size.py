# SPDX-License-Identifier: MIT
"""Flash and RAM of the image by room, from the linker's map."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

_LIBRARIES = {
    "libm.a": "libm",
    "libgcc.a": "libgcc",
    "libc_nano.a": "libc",
    "libstdc++_nano.a": "libstdc++",
}
# Rooms by namespace: after link-time optimisation the map names no source files.
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


def _pieces(linker_map: str) -> Iterator[tuple[int, int, str, str]]:
    """The entries of the map: address, bytes, room, section."""
    text = linker_map.split("\nLinker script and memory map\n")[1]
    # The map puts a long name on a line of its own.
    text = re.sub(r"^( \.\S+)\n\s+0x", r"\1 0x", text, flags=re.MULTILINE)
    for line in text.splitlines():
        if gap := _GAP.match(line):
            yield int(gap[1], 16), int(gap[2], 16), "gaps", ""
        elif (piece := _PIECE.match(line)) and piece[1]:
            section = piece[1]
            if not section.startswith((".debug", ".comment", ".ARM.attributes", ".note")):
                yield int(piece[2], 16), int(piece[3], 16), _room(section, piece[4]), section


def sizes(linker_map: Path) -> tuple[Counter[str], Counter[str]]:
    """Bytes of flash and of RAM by room; initialised data counts in both."""
    flash: Counter[str] = Counter()
    ram: Counter[str] = Counter()
    pieces = sorted(piece for piece in _pieces(linker_map.read_text()) if piece[1] > 0)
    ends = [place for place, *_ in pieces[1:]] + [2**32]
    for (place, size, room, section), end in zip(pieces, ends, strict=True):
        # Merged strings are listed with their size before merging: count up to the next entry.
        taken = min(size, end - place)
        if place >= _RAM:
            ram[room] += taken
        if place < _RAM or section.startswith(".data"):
            flash[room] += taken
    return flash, ram
