# SPDX-License-Identifier: MIT
"""Builds that ship are compiled from the files that they name, and share objects in the cache."""

import json
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_only_the_tests_with_sanitizers_and_the_image_precompile_headers() -> None:
    """Elsewhere a forgotten include would go unseen, and clones would share no objects."""
    presets = json.loads((ROOT / "CMakePresets.json").read_text(encoding="utf-8"))
    name = "CMAKE_DISABLE_PRECOMPILE_HEADERS"
    set_by = {
        preset["name"]: preset["cacheVariables"][name]
        for preset in presets["configurePresets"]
        if name in preset["cacheVariables"]
    }
    assert set_by == {"dev": "OFF", "cortex-m": "OFF"}
    assert f"set({name} ON CACHE BOOL" in (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
