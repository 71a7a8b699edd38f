# SPDX-License-Identifier: MIT
"""Published figures as JSON: 6 digits, so that files differ only where results do."""

import json
import math
from typing import Any

from sil.common import files

_DIGITS = 6


def line(value: Any) -> str:
    """A value as one line of JSON; non-finite numbers become null."""
    return json.dumps(files.plain(_rounded(value)), ensure_ascii=False, allow_nan=False)


def numbers(value: Any) -> Any:
    """Replace the file's null by infinity."""
    if isinstance(value, dict):
        return {key: numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [numbers(item) for item in value]
    return math.inf if value is None else value


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value
