# SPDX-License-Identifier: MIT
"""Fails if a file of core has a floating literal outside S(...): a scalar need not be a float."""

import re
import sys
from pathlib import Path

SCALAR = re.compile(r"\bS\(-?\d+(\.\d+)?([eE][-+]?\d+)?\)")
FLOATING = re.compile(
    r"(?<![\w.])((\d+\.\d*|\.\d+|\d+(?=[eE][-+]?\d))([eE][-+]?\d+)?|0[xX][\da-fA-F.]+[pP])"
)

found = [
    f"{path}:{number}: floating literal outside S(...): {line.strip()}"
    for path in sys.argv[1:]
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), 1)
    if FLOATING.search(SCALAR.sub("", line.split("//")[0]))
]
sys.exit("\n".join(found) or 0)
