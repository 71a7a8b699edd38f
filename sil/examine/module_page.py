# SPDX-License-Identifier: MIT
"""The generated parts of sil/docs/MODULE.md: the native module's stub, a snapshot's keys."""

import re
from pathlib import Path

import flotilla

from sil import ROOT

PAGE = ROOT / "sil" / "docs" / "MODULE.md"
COUNTERS = ROOT / "firmware" / "link" / "counters.hpp"
MEANINGS = {
    "state": "state of the supervisor, one of `flotilla.STATES`",
    "conditions": "each [condition](../../firmware/docs/SUPERVISOR.md#conditions): is it met?",
    "own_age_s": "age of the own state; `None`: no state, or its age is unknown",
    "leader_age_s": "age of the leader's state, likewise",
    "leader_uncertainty_m": "greatest error of the leader's position as the boat estimates it",
    "reference_age_s": "age of the formation's reference; `None`: the boat does not follow one",
    "unknown": "surge force and yaw moment that the vessel model does not explain",
    "current_mps": "estimated velocity of the water",
    "error": "offset from the slot in the boat's axes: `x_m` ahead, `y_m` to starboard, `psi_rad`; "
    "`None` while a state is too old",
    "in_slot": "in FORMATION: the boat is in its slot; otherwise it is closing up",
    "virtual_velocity": "velocity that the law asks for",
    "wrench_asked": "surge force and yaw moment that the law asks for",
    "wrench_given": "the part of it that the two propellers give",
    "limited": "which limits acted; `yielding`: the boat gives way to another vessel",
    "slot_needs": "speed and yaw rate that the slot needs where they are over `LAW_U_MAX` or "
    "`LAW_R_MAX`, otherwise 0",
    "separation_m": "predicted distance of the nearest vessel; `None`: there is none",
    "thrust_N": "thrust of each propeller",
    "counters": "messages and frames received, sent and discarded: the next table",
}


def stub() -> str:
    """The stub that is installed with the module, as a block of code."""
    text = Path(flotilla.__file__).with_name("flotilla.pyi").read_text(encoding="utf-8")
    return f"```python\n{text.rstrip()}\n```"


def snapshot_table() -> str:
    """Every key of `Boat.snapshot()`, its nested keys, and their meaning."""
    lines = ["| key | keys within | meaning |", "|---|---|---|"]
    for key, value in flotilla.Boat({}).snapshot().items():
        named = key in ("conditions", "counters") or not isinstance(value, dict)
        inner = "" if named else " ".join(f"`{name}`" for name in value)
        lines.append(f"| `{key}` | {inner} | {MEANINGS[key]} |")
    return "\n".join(lines)


def counter_table() -> str:
    """Every counter of a snapshot, as the firmware's header explains it."""
    text = COUNTERS.read_text(encoding="utf-8")
    said = dict(re.findall(r"(\w+) = 0; +///< (.+)", text))
    lines = ["| counter | counts |", "|---|---|"]
    lines += [f"| `{name}` | {said[name]} |" for name in flotilla.Boat({}).snapshot()["counters"]]
    return "\n".join(lines)
