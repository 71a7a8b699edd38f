# SPDX-License-Identifier: MIT
"""The tables of firmware/docs/SUPERVISOR.md, computed with the firmware's own table."""

from collections import defaultdict
from collections.abc import Iterable

import flotilla

from sil import ROOT

PAGE = ROOT / "firmware" / "docs" / "SUPERVISOR.md"
PUSHING = ("MANUAL", "FORMATION", "COAST", "AUTO", "GUIDED", "LOITER", "RTL", "TEST")
MODES = ("MANUAL", "FORMATION", "AUTO", "GUIDED", "LOITER", "RTL")
ASKED = {mode: mode for mode in MODES} | {"TEST": "test"}
BY_LAW = ("FORMATION", "AUTO", "GUIDED", "LOITER", "RTL")
#: The loss, by the parameter that determines the reaction.
LOSSES = {
    "FS_LEADER_ACT": "leader_fresh",
    "FS_GCS_ACT": "gcs_heard",
    "FS_BATT_ACT": "battery_good",
    "FS_FENCE_ACT": "inside_fence",
}
NAMES = tuple(c["name"] for c in flotilla.supervisor_conditions())


def after(state: str, request: str, lost: Iterable[str] = (), chosen: Iterable[str] = ()) -> str:
    """The state after a request if only `lost` is unmet, with the default choices and `chosen`."""
    met = [name for name in NAMES if name not in lost]
    return str(flotilla.supervise(state, request, [*met, *chosen])["state"])


def table(head: tuple[str, ...], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    first, *others = ["| " + " | ".join(cells) + " |" for cells in (head, *rows)]
    return "\n".join([first, "|" + "---|" * (first.count(" | ") + 1), *others])


def condition_table() -> str:
    """Every condition: name, bit of COND or COND2, the boat's message if unmet, limit, need."""
    rows = []
    for c in flotilla.supervisor_conditions():
        name = c["name"]
        needed = ["to arm"] if after("DISARMED", "arm", [name]) == "DISARMED" else []
        states = [s for s, ask in ASKED.items() if after("HOLD", ask, [name]) != s]
        if set(BY_LAW) <= set(states):
            states = [*(s for s in states if s not in BY_LAW), "every mode of the law"]
        needed += [f"for {state}" for state in states]
        # A condition that no request needs is needed for thrust.
        needed = needed or [f"for thrust in {state}" for state in PUSHING if stills(state, name)]
        limit = f"`{c['limit']}`" if c["limit"] else ""
        value, bit = divmod(c["bit"], 24)
        where = f"{bit} of `COND2`" if value else str(bit)
        rows.append([f"`{name}`", where, c["complaint"], limit, ", ".join(needed)])
    head = ("condition", "bit of `COND`", "message if unmet", "limit", "needed")
    return table(head, rows)


def stills(state: str, name: str) -> bool:
    """Whether the propellers stop in a state, without a request, if only `name` is unmet."""
    return not flotilla.supervise(state, "arm", [n for n in NAMES if n != name])["drives"]


def way_back(state: str, fallen: str) -> str:
    """The way in which a boat returns to a state after a loss, once all conditions are met."""
    if after(fallen, "nothing") == state:
        return "by itself"
    request = ASKED.get(state, "nothing")
    if after(fallen, request) == state:
        return "asked for"
    return "disarm first"


def loss_table() -> str:
    """The effect of losing each condition in each armed state, and the boat's way back."""
    states = [s for s in flotilla.STATES if s not in ("DISARMED", "FAULT")]
    groups: dict[tuple[str, ...], list[str]] = defaultdict(list)
    for name in NAMES:
        cells = []
        for state in states:
            fallen = after(state, "nothing", [name, *(["leader_fresh"] * (state == "COAST"))])
            if fallen == state:
                cells.append("")
            else:
                back = "FORMATION" if state == "COAST" else state
                cells.append(f"{fallen}; {way_back(back, fallen)}")
        groups[tuple(cells)].append(f"`{name}`")
    rows = [["<br>".join(names), *cells] for cells, names in groups.items() if any(cells)]
    return table(("lost", *(f"in {s}" for s in states)), rows)


def choice_table() -> str:
    """The effect of each failsafe choice at the loss to which it applies."""
    rows = []
    for choice in flotilla.supervisor_choices():
        parameter = choice["name"]
        for number in range(len(choice["reactions"])):
            chosen = [f"{parameter} {number}"]
            default = " (default)" if number == choice["default"] else ""
            name = f"`{parameter}` {number}{default}"
            if parameter == "FS_COAST_ACT":
                over = after("COAST", "nothing", ["leader_fresh", "coast_running"], chosen)
                rows.append([name, "COAST is over", over, over])
                continue
            lost = LOSSES[parameter]
            held = after("FORMATION", "nothing", [lost], chosen)
            free = after("FORMATION", "nothing", [lost, "sticks_fresh"], chosen)
            then = f"{free}, then `FS_COAST_ACT` decides" if free == "COAST" else free
            when = f"no `{lost}`" if lost != "leader_fresh" else "any `leader_…` condition lost"
            rows.append([name, when, then, held if held != free else then])
    return table(("choice", "when", "FORMATION goes to", "with fresh sticks"), rows)


def transition_table() -> str:
    """The supervisor's table, row by row."""
    rows = [
        [
            "any" if len(row["from"]) == len(flotilla.STATES) else ", ".join(row["from"]),
            "automatic" if row["request"] == "nothing" else row["request"],
            ", ".join(row["needs"]),
            ", ".join(row["lacks"]),
            ", ".join(row["on"]),
            row["to"],
        ]
        for row in flotilla.supervisor_table()
    ]
    return table(
        ("state", "request", "requires", "and at least one unmet", "failsafe action", "next state"),
        rows,
    )


def edges() -> dict[tuple[str, str], list[str]]:
    """A boat's transitions: requested, by a loss, or by a recovery.

    Without disarming, and without requests that lead from one mode to another.
    """
    out: dict[tuple[str, str], list[str]] = defaultdict(list)
    for state in flotilla.STATES:
        for request in ("arm", "HOLD", *ASKED.values()):
            to = after(state, request)
            between = state not in ("DISARMED", "HOLD") and to != "HOLD"
            if to not in (state, after(state, "nothing")) and not between:
                out[state, to].append(request)
        if after(state, "nothing") != state:
            out[state, after(state, "nothing")].append("all is well again")
        for name in NAMES:
            away = ["leader_fresh"] if state == "COAST" else []
            to = after(state, "nothing", [*away, name])
            if to != state and name not in away:
                out[state, to].append(f"no {name}")
    return out


def diagram() -> str:
    """A Mermaid flowchart; solid: requested, dotted: automatic."""
    lines = ["```mermaid", "flowchart TD"]
    for (state, to), causes in edges().items():
        asked = [c for c in causes if not c.startswith(("no ", "all "))]
        lost = [c for c in causes if c.startswith(("no ", "all "))]
        if asked:
            lines.append(f'  {state} -->|"{", ".join(asked)}"| {to}')
        if lost:
            lines.append(f'  {state} -.->|"{"<br>".join(lost)}"| {to}')
    for kind, states in (("pushes", PUSHING), ("stopped", set(flotilla.STATES) - set(PUSHING))):
        lines.append(f"  class {','.join(s for s in flotilla.STATES if s in states)} {kind}")
    lines += ["  classDef pushes stroke-width:3px", "  classDef stopped stroke-dasharray:4", "```"]
    return "\n".join(lines)
