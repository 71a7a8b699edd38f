# SPDX-License-Identifier: MIT
"""Byte pair encoding (P. Gage, A New Algorithm for Data Compression, 1994), by pages."""

import sys
from collections import Counter
from itertools import pairwise
from typing import NamedTuple

PAGE, DEPTH = 512, 32  # as in link/mavlink/packed_text.hpp
WORTH = 3  # a pair costs two bytes, its second use saves one


class Packed(NamedTuple):
    """Packed bytes, the start of each page in them, and the meaning of each of 256 bytes."""

    data: bytes
    pages: list[int]
    pairs: list[tuple[int, int]]


def _replaced(page: list[int], pair: tuple[int, int], code: int) -> list[int]:
    out: list[int] = []
    for byte in page:
        if out and (out[-1], byte) == pair:
            out[-1] = code
        else:
            out.append(byte)
    return out


def pack(text: bytes) -> Packed:
    """Pack a text without NUL; a pair never crosses the end of a page."""
    pages = [list(text[at : at + PAGE]) for at in range(0, len(text), PAGE)]
    pairs, depth = [(byte, 0) for byte in range(256)], [0] * 256
    for code in sorted(set(range(1, 256)) - set(text)):
        counts = Counter(pair for page in pages for pair in pairwise(page))
        pair, count = max(counts.items(), key=lambda entry: (entry[1], entry[0]))
        if count <= WORTH:
            break
        pairs[code] = pair
        depth[code] = 1 + max(depth[byte] for byte in pair)
        pages = [_replaced(page, pair, code) for page in pages]
    if 0 in text or max(depth) > DEPTH:
        sys.exit("byte_pairs: a text with NUL, or pairs too deep")
    begins, data = [], bytearray()
    for page in pages:
        begins.append(len(data))
        data += bytes(page)
    return Packed(bytes(data), begins, pairs)
