# SPDX-License-Identifier: MIT
"""The folder for a verb's results."""

import json
from pathlib import Path


def claim(out: Path, marker: str, scenario: str) -> Path:
    """Return `out`, unless it is a file or holds results of another verb or another scenario.

    `marker`: the JSON file that identifies the verb's results and has their "scenario"; results of
    other verbs are recognized by a page. Files that an interrupted command left may be overwritten.
    ValueError names the folder and the remedy.
    """
    if out.exists() and not out.is_dir():
        raise ValueError(f"--out {out}: is a file; name a folder")
    if not (out / marker).exists() and not list(out.glob("*.html")):
        return out
    try:
        held = json.loads((out / marker).read_text(encoding="utf-8"))["scenario"]
    except (OSError, ValueError, KeyError, TypeError):
        held = None
    if held == scenario:
        return out
    what = f'the results of "{held}"' if held else "files that this command has not made"
    raise ValueError(f"{out} holds {what}: name another folder with --out, or remove it")
