# SPDX-License-Identifier: MIT
"""JSON for the page."""

import json
from math import isfinite
from typing import Any


def json_of(value: object) -> str:
    """JSON text. Non-finite numbers become null: one from the radio must not stop the page."""
    try:
        return json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    except ValueError:
        return json_of(_finite(value))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value
