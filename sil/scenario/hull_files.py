# SPDX-License-Identifier: MIT
"""A hull's parameters as files that ground stations load: `NAME.param` and `NAME.params`.

`.param`: one line `NAME,VALUE` for each parameter; Mission Planner and MAVProxy load it, and
flotillad with `--param-file`. `.params`: QGroundControl's five columns, separated by tabs.
"""

from sil.scenario import presets

_REAL32 = 9  # MAV_PARAM_TYPE


def texts(name: str) -> dict[str, str]:
    """The files of a hull by suffix; ScenarioError as `presets.path_of`."""
    hull = presets.load(name)
    values = presets.firmware(hull)
    head = [
        f"# {about(name)}",
        f"# At {hull.cruise.speed_mps:g} m/s; made by tools/reference from sil/hulls/{name}.toml,",
        "# which has the source of each number and says which are estimates.",
    ]
    return of_values(values, head)


def of_values(values: dict[str, float], head: list[str]) -> dict[str, str]:
    """Both files of the given parameters; the lines of `head` come first, as comments."""
    plain = [f"{parameter},{value:.9g}" for parameter, value in values.items()]
    columns = [f"1\t1\t{own}\t{value:.9g}\t{_REAL32}" for own, value in values.items()]
    return {
        "param": "\n".join([*head, *plain]) + "\n",
        "params": "\n".join([*head, *columns]) + "\n",
    }


def about(name: str) -> str:
    """The boat's description: the first comment of the hull's file."""
    lines = presets.path_of(name).read_text(encoding="utf-8").splitlines()
    return lines[1].removeprefix("# ")
