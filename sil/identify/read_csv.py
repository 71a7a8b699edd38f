# SPDX-License-Identifier: MIT
"""Logs as tables: CSV with named columns, units in the names.

time (`t_s`, `t_ms`, `t_us`), position (`north_m`, `east_m`, or `lat_deg`, `lon_deg`), heading
(`yaw_deg`, `yaw_rad`), speed over ground ahead and to starboard (`surge_mps`, `sway_mps`), yaw rate
(`yaw_rate_radps`, `yaw_rate_degps`), and the command to each propeller: `port`, `stbd` (−1 … 1) or
`pwm_port_us`, `pwm_stbd_us`; 400 µs from the stop is ±1. `left` and `right` also stand for port and
stbd, `heading` for yaw.
"""

from pathlib import Path

import numpy as np

from sil.identify.voyage_log import Array, BadLogError, Channel, VoyageLog, sampled

_METRES_PER_DEGREE = 111_195.0
_LARGEST_HEADING = 4.0 * np.pi
_TURN_AT_ONCE = 45.0  # rad/s: no boat turns so fast
_STOP_PWM = (1450.0, 1550.0)
_STOPPED = 0.1  # share of the samples at one pulse width: that is a stop
FULL_US = 400.0
_MOST = {
    "north_m": 2e7,
    "east_m": 2e7,
    "lat_deg": 90.0,
    "lon_deg": 360.0,
    "surge_mps": 50.0,
    "sway_mps": 50.0,
}
_USUAL_PWM = (1100.0, 1900.0)
_ALIASES = (("left", "port"), ("right", "stbd"), ("starboard", "stbd"), ("heading", "yaw"))


def read_csv(path: Path) -> tuple[VoyageLog, list[str]]:
    """The log, and sentences about the assumptions. Raises `BadLogError`.

    Commands exceed ±1 if pulses are outside 1100 … 1900 µs.
    """
    columns = _columns(path)
    notes: list[str] = []
    _check_sizes(path, columns)
    t = _time(path, columns)
    motion = [
        Channel(t, _position(path, columns)),
        Channel(t, _heading(path, columns)[:, None]),
        Channel(t, np.column_stack([_need(path, columns, n) for n in ("surge_mps", "sway_mps")])),
        Channel(t, _yaw_rate(path, columns)[:, None]),
    ]
    commands = np.column_stack([_command(path, columns, side, notes) for side in ("port", "stbd")])
    # A row has the last command before it, which began half a row earlier on average.
    given = Channel(t - 0.5 * float(np.median(np.diff(t))), commands)
    return sampled(path.stem, motion, given), notes


def _columns(path: Path) -> dict[str, Array]:
    # Spreadsheet programs write a byte order mark first.
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        head = file.readline()
        names = [name.strip().lower() for name in head.split(",")]
        if len(names) == 1 and any(sign in head for sign in ";\t"):
            raise BadLogError(f"{path}: the columns must be separated by commas")
        if "" in names or len(set(names)) < len(names) or not names[0][:1].isalpha():
            raise BadLogError(
                f"{path}: the first line does not name the columns. Write names such as "
                "t_s, north_m, east_m, yaw_deg, surge_mps, sway_mps, yaw_rate_radps, port, stbd."
            )
        try:
            rows = [head, *file]
            if len(rows) > 2 and not rows[-1].endswith("\n"):
                rows.pop()  # a log ends in mid-line where the power was cut
            table = np.empty((0, 0))
            if len(rows) > 1:
                table = np.genfromtxt(rows, delimiter=",", ndmin=2, skip_header=1)
        except ValueError as error:
            told = str(error).splitlines()[:2][-1].strip()
            for number, row in enumerate(rows, start=1):
                if row.strip() and row.count(",") != head.count(","):
                    values = row.count(",") + 1
                    told = f"line {number} has {values} values, for {len(names)} columns"
                    break
            raise BadLogError(f"{path}: {told}") from None
    if table.shape[0] < 2 or table.shape[1] != len(names):
        raise BadLogError(
            f"{path}: {table.shape[0]} rows of {table.shape[1]} values; "
            f"at least 2 rows of {len(names)} values are needed"
        )
    given: dict[str, str] = {}
    for name in names:
        known = name
        for other, ours in _ALIASES:
            known = known.replace(other, ours)
        if known in given:
            raise BadLogError(
                f"{path}: {given[known]} and {name} mean the same: leave one of them out"
            )
        given[known] = name
    return dict(zip(given, table.T, strict=True))


def _check_sizes(path: Path, columns: dict[str, Array]) -> None:
    for name, most in _MOST.items():
        values = columns.get(name, np.empty(0))
        beyond = np.flatnonzero(np.isfinite(values) & (np.abs(values) > most))
        if len(beyond):
            raise BadLogError(
                f"{path}: {name} is {values[beyond[0]]:.6g} in row {beyond[0] + 1} after the "
                f"names, but at most ±{most:g} is possible. Check its unit, or leave the cell empty"
            )


def _need(path: Path, columns: dict[str, Array], *names: str) -> Array:
    for name in names:
        if name in columns:
            return columns[name]
    there = ", ".join(columns)
    raise BadLogError(f"{path}: no column {' or '.join(names)}; the columns are {there}")


def _time(path: Path, columns: dict[str, Array]) -> Array:
    for name, scale in (("t_s", 1.0), ("t_ms", 1e-3), ("t_us", 1e-6)):
        if name in columns:
            t = columns[name] * scale
            if not (np.all(np.isfinite(t)) and np.all(np.diff(t) > 0.0)):
                raise BadLogError(
                    f"{path}: {name} does not increase from row to row; sort the rows by time"
                )
            since: Array = t - t[0]
            return since
    _need(path, columns, "t_s", "t_ms", "t_us")
    raise AssertionError


def _position(path: Path, columns: dict[str, Array]) -> Array:
    if "north_m" in columns and "east_m" in columns:
        local: Array = np.column_stack([columns["north_m"], columns["east_m"]])
        return local
    lat, lon = _need(path, columns, "lat_deg"), _need(path, columns, "lon_deg")
    middle = np.nanmean(lat)
    east = (lon - np.nanmean(lon)) * np.cos(np.radians(middle))
    position: Array = _METRES_PER_DEGREE * np.column_stack([lat - middle, east])
    return position


def _heading(path: Path, columns: dict[str, Array]) -> Array:
    if "yaw_deg" in columns:
        angle = np.radians(columns["yaw_deg"])
    else:
        angle = _need(path, columns, "yaw_rad", "yaw_deg")
        if _largest(angle) > _LARGEST_HEADING and _largest(np.diff(angle)) > 7.0:
            raise BadLogError(
                f"{path}: yaw_rad reaches {_largest(angle):.0f}, which "
                "looks like degrees. If so, name the column yaw_deg."
            )
    known = np.isfinite(angle)
    out: Array = np.full_like(angle, np.nan)
    out[known] = np.unwrap(angle[known])
    return out


def _yaw_rate(path: Path, columns: dict[str, Array]) -> Array:
    if "yaw_rate_degps" in columns:
        rate: Array = np.radians(columns["yaw_rate_degps"])
    else:
        rate = _need(path, columns, "yaw_rate_radps", "yaw_rate_degps")
    if _largest(rate) > _TURN_AT_ONCE:
        raise BadLogError(
            f"{path}: a yaw rate of {_largest(rate):.0f} rad/s; "
            "if yaw_rate_radps is in degrees per second, name it yaw_rate_degps."
        )
    return rate


def _command(path: Path, columns: dict[str, Array], side: str, notes: list[str]) -> Array:
    if side in columns:
        share = columns[side]
        if not np.isfinite(share).any():
            raise BadLogError(f"{path}: {side} has no values")
        if _largest(share) > 1.01:
            raise BadLogError(
                f"{path}: {side} reaches {_largest(share):.4g}, a command is −1 … 1. "
                f"If it is a pulse width, name the column pwm_{side}_us; a thrust in newtons "
                "must be divided by the greatest one."
            )
        return np.clip(share, -1.0, 1.0)
    pwm = _need(path, columns, f"pwm_{side}_us", f"{side}_pwm_us", side)
    if not np.isfinite(pwm).any():
        raise BadLogError(f"{path}: the {side} propeller's pulse width has no values")
    if not (np.nanmin(pwm) > 800.0 and np.nanmax(pwm) < 2200.0):
        raise BadLogError(
            f"{path}: pwm_{side}_us is {np.nanmin(pwm):.4g} … {np.nanmax(pwm):.4g}, "
            "but a pulse width is 1000 … 2000 µs"
        )
    near = pwm[(pwm > _STOP_PWM[0]) & (pwm < _STOP_PWM[1])]
    values, counts = np.unique(np.round(near), return_counts=True)
    often = len(values) > 0 and counts.max() > _STOPPED * len(pwm)
    stop = float(values[np.argmax(counts)]) if often else 1500.0
    if stop != 1500.0:
        notes.append(f"the {side} propeller stands still at {stop:.0f} µs, not at 1500")
    share = (pwm - stop) / FULL_US
    if np.nanmin(pwm) < _USUAL_PWM[0] or np.nanmax(pwm) > _USUAL_PWM[1]:
        return share
    # If the stop is not 1500, one side is longer; on a real BlueBoat that gives no more thrust.
    return np.clip(share, -1.0, 1.0)


def _largest(values: Array) -> float:
    """The largest size of the known values; 0 if none is known."""
    return float(np.nanmax(np.abs(values), initial=0.0))
