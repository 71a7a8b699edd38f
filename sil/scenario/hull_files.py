# SPDX-License-Identifier: MIT
"""A hull's parameters as files that ground stations load: `NAME.param` and `NAME.params`.

`.param`: one line `NAME,VALUE` for each parameter; Mission Planner and MAVProxy load it, and
flotillad with `--param-file`. `.params`: QGroundControl's five columns, separated by tabs.
"""

from sil import ROOT
from sil.scenario import presets

_REAL32 = 9  # MAV_PARAM_TYPE


def texts(name: str) -> dict[str, str]:
    """The files of a hull by suffix; ScenarioError as `presets.path_of`."""
    hull, path = presets.load(name), presets.path_of(name)
    speed = f"# At {hull.cruise.speed_mps:g} m/s; made by"
    if path.parent == presets.FOLDER:
        made = [
            f"{speed} tools/reference from {path.relative_to(ROOT).as_posix()},",
            "# which has the source of each number and says which are estimates.",
        ]
    else:
        made = [f"{speed} flotilla hulls from {path}"]
    return of_values(presets.firmware(hull), [f"# {about(name)}", *made])


def of_values(values: dict[str, float], head: list[str]) -> dict[str, str]:
    """Both files of the given parameters; the lines of `head` come first, as comments."""
    plain = [f"{parameter},{value:.9g}" for parameter, value in values.items()]
    columns = [f"1\t1\t{own}\t{value:.9g}\t{_REAL32}" for own, value in values.items()]
    return {
        "param": "\n".join([*head, *plain]) + "\n",
        "params": "\n".join([*head, *columns]) + "\n",
    }


def about(name: str) -> str:
    """The boat's description: the first comment of the hull's file but its licence."""
    lines = presets.path_of(name).read_text(encoding="utf-8-sig").splitlines()
    comments = [line.lstrip("# ") for line in lines if line.startswith("#") and "SPDX" not in line]
    return comments[0] if comments else name
