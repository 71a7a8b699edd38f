# SPDX-License-Identifier: MIT
"""A hull's parameters as files that ground stations load: `NAME.param` and `NAME.params`.

`.param`: a line `NAME,VALUE` each, which Mission Planner and MAVProxy load, and flotillad by
`--param-file`. `.params`: QGroundControl's five columns, separated by tabs.
"""

from sil.scenario import presets

_REAL32 = 9  # MAV_PARAM_TYPE


def texts(name: str) -> dict[str, str]:
    """The files of a hull by their suffixes; ScenarioError as `presets.path_of`."""
    hull = presets.load(name)
    values = presets.firmware(hull)
    head = [
        f"# {about(name)}",
        f"# At {hull.cruise.speed_mps:g} m/s; made by tools/reference from sil/hulls/{name}.toml,",
        "# which has the source of each number and says which are estimates.",
    ]
    plain = [f"{parameter},{value:.9g}" for parameter, value in values.items()]
    columns = [f"1\t1\t{own}\t{value:.9g}\t{_REAL32}" for own, value in values.items()]
    return {
        "param": "\n".join([*head, *plain]) + "\n",
        "params": "\n".join([*head, *columns]) + "\n",
    }


def about(name: str) -> str:
    """What boat it is: the first comment of its file."""
    lines = presets.path_of(name).read_text(encoding="utf-8").splitlines()
    return lines[1].removeprefix("# ")
