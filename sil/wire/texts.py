# SPDX-License-Identifier: MIT
"""A vessel's STATUSTEXTs, reassembled from their chunks."""

CHUNK_BYTES = 50


class Texts:
    """The last complete text, and when it arrived (s)."""

    def __init__(self) -> None:
        self.last = ""
        self.said_s = 0.0
        self._pieces: dict[int, tuple[int, list[bytes]]] = {}

    def hear(self, component: int, piece: bytes, number: int, chunk: int, now_s: float) -> None:
        """Process a STATUSTEXT; `number` 0 is a whole text, others come in chunks from 0 on.

        A text with a lost chunk is dropped.
        """
        pieces = [piece]
        if number:
            known, before = self._pieces.get(component, (0, []))
            before = before if known == number else []
            if chunk != len(before):
                return
            pieces = [*before, piece]
            self._pieces[component] = number, pieces
            if b"\0" not in piece and len(pieces) < 256:
                return
        self.last = b"".join(pieces).split(b"\0")[0].decode("utf-8", "replace")
        self.said_s = now_s
