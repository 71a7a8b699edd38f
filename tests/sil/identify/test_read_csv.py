# SPDX-License-Identifier: MIT
"""Tables with named columns: units by name, nonsense refused with a sentence."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sil.identify.log_files import read
from sil.identify.read_csv import read_csv
from sil.identify.voyage_log import SAMPLE_S, BadLogError
from tests.sil.identify.sailed import Noise, levels, sail

Columns = dict[str, np.ndarray]


def columns() -> Columns:
    rng = np.random.default_rng(1)
    commands = levels(rng, 30.0)
    commands[:80] = 0.0
    log = sail(commands, rng, Noise(0.0, 0.0, 0.0, 0.0))
    names = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
    table = dict(zip(names, log.motion.T, strict=True))
    table |= {"port": log.commands[:, 0], "stbd": log.commands[:, 1]}
    return {"t_s": np.arange(len(log.motion)) * SAMPLE_S, **table}


def written(folder: Path, table: Columns) -> Path:
    path = folder / "log.csv"
    rows = np.column_stack(list(table.values()))
    np.savetxt(path, rows, "%.9g", ",", header=",".join(table), comments="")
    return path


def test_a_table_in_si_is_taken_as_it_is(tmp_path: Path) -> None:
    table = columns()
    log, notes = read_csv(written(tmp_path, table))
    assert notes == []
    motion = np.column_stack(list(table.values())[1:7])
    assert np.allclose(log.motion, motion[: len(log.motion)], atol=1e-6)
    given = np.column_stack([table["port"], table["stbd"]])
    # A row's command began half a row earlier, on average.
    mean = 0.5 * (given[:-1] + given[1:])
    assert np.allclose(log.commands[1:-1], mean[1 : len(log.commands) - 1], atol=1e-6)


def test_degrees_milliseconds_pulses_and_other_names_give_the_same_log(tmp_path: Path) -> None:
    table = columns()
    plain, _ = read_csv(written(tmp_path, table))
    other = {
        "t_ms": 1e3 * (table["t_s"] + 77.0),
        "north_m": table["north_m"],
        "east_m": table["east_m"],
        "heading_deg": np.degrees(table["yaw_rad"]) % 360.0,
        "surge_mps": table["surge_mps"],
        "sway_mps": table["sway_mps"],
        "yaw_rate_degps": np.degrees(table["yaw_rate_radps"]),
        "pwm_left_us": 1510.0 + 400.0 * table["port"],
        "pwm_right_us": 1510.0 + 400.0 * table["stbd"],
    }
    log, notes = read_csv(written(tmp_path, other))
    turns = (log.motion[0, 2] - plain.motion[0, 2]) / (2.0 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-6)
    log.motion[:, 2] -= 2.0 * np.pi * round(turns)
    assert np.allclose(log.motion, plain.motion, atol=1e-4)
    assert np.allclose(log.commands, plain.commands, atol=1e-6)
    assert [note for note in notes if "1510" in note] == notes and len(notes) == 2


def test_an_empty_cell_of_a_command_means_that_the_last_one_holds(tmp_path: Path) -> None:
    table = columns()
    table["port"] = np.round(table["port"], 6)
    changed = np.append(True, np.diff(table["port"]) != 0.0)
    assert 5 < changed.sum() < len(changed) / 5
    plain, _ = read_csv(written(tmp_path, table))
    log, _ = read_csv(
        written(tmp_path, {**table, "port": np.where(changed, table["port"], np.nan)})
    )
    assert np.allclose(log.commands, plain.commands)
    table["port"][:100] = np.nan
    log, _ = read_csv(written(tmp_path, table))
    assert np.all(log.commands[:90, 0] == 0.0)


def test_pulses_beyond_400_us_are_scaled_alike_in_all_logs_and_noted(tmp_path: Path) -> None:
    far, near = columns(), columns()
    far["port"][-20:], far["stbd"][-20:] = 1.0, -0.8
    near["port"][100:] *= 0.5
    near["stbd"][100:] *= 0.5
    plain, paths = [], []
    for k, table in enumerate((far, near)):
        plain.append(read_csv(written(tmp_path, table))[0])
        pulses = {f"pwm_{side}_us": 1500.0 + 500.0 * table.pop(side) for side in ("port", "stbd")}
        paths.append(written(tmp_path, table | pulses).rename(tmp_path / f"{k}.csv"))
    logs, notes = read(paths)
    for log, wanted in zip(logs, plain, strict=True):
        assert np.allclose(log.commands, wanted.commands, atol=1e-6)
    assert notes == ["full thrust is taken as 500 µs from the stop, not as 400"]


def test_a_stop_pulse_beside_1500_us_keeps_commands_within_full_thrust(
    tmp_path: Path,
) -> None:
    table = columns()
    table["port"][-20:] = -1.0
    for side in ("port", "stbd"):
        table[f"pwm_{side}_us"] = np.clip(1510.0 + 410.0 * table.pop(side), 1100.0, 1900.0)
    ((log,), notes) = read([written(tmp_path, table)])
    assert np.abs(log.commands).max() == pytest.approx(1.0)
    assert len(notes) == 2 and all("1510" in note for note in notes)


@pytest.mark.parametrize(("ours", "other"), [("yaw_rad", "heading_rad"), ("port", "left")])
def test_two_columns_that_mean_the_same_are_refused(tmp_path: Path, ours: str, other: str) -> None:
    table = columns()
    table[other] = table[ours]
    with pytest.raises(BadLogError, match=f"{ours} and {other} mean the same"):
        read_csv(written(tmp_path, table))


def test_a_log_of_one_row_a_second_is_refused_with_its_rate(tmp_path: Path) -> None:
    table = {name: np.repeat(column, 10) for name, column in columns().items()}
    table["t_s"] = np.arange(len(table["t_s"])) * 0.1
    slow = {name: column[::10] for name, column in table.items()}
    with pytest.raises(BadLogError, match=r"the speed comes at 1 Hz; 2 Hz or more is needed"):
        read_csv(written(tmp_path, slow))


def test_a_byte_order_mark_and_capital_letters_are_understood(tmp_path: Path) -> None:
    path = written(tmp_path, columns())
    plain, _ = read_csv(path)
    marked = tmp_path / "LOG.CSV"
    marked.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    ((log,), _) = read([marked])
    assert np.array_equal(log.motion, plain.motion)


def test_latitudes_are_metres_as_geopy_has_them(tmp_path: Path) -> None:
    table = columns()
    table["lat_deg"] = 63.4 + table.pop("north_m") / 111_195.0
    table["lon_deg"] = 10.3 + table.pop("east_m") / (111_195.0 * np.cos(np.radians(63.4)))
    log, _ = read_csv(written(tmp_path, table))
    other = columns()
    moved = np.column_stack([other["north_m"], other["east_m"]])
    offset = log.motion[0, :2] - moved[0]
    assert np.allclose(log.motion[:, :2] - offset, moved[: len(log.motion)], atol=0.01)


def test_a_gap_has_no_measurements(tmp_path: Path) -> None:
    table = {name: np.delete(column, slice(100, 120)) for name, column in columns().items()}
    log, _ = read_csv(written(tmp_path, table))
    assert np.all(np.isnan(log.motion[101:119]))
    assert np.all(np.isfinite(log.motion[:99])) and np.all(np.isfinite(log.motion[121:]))


NONSENSE: dict[str, tuple[str, Callable[[Any], Any], str]] = {
    "degrees": ("yaw_rad", lambda c: np.degrees(c) % 360.0 * 1.0, "looks like degrees"),
    "pulses": ("port", lambda c: 1500.0 + 400.0 * c, "pwm_port_us"),
    "newtons": ("stbd", lambda c: 35.0 * c, "thrust in newtons"),
    "fast turns": ("yaw_rate_radps", lambda c: 100.0 * np.degrees(c), "degrees per second"),
    "time that stands": ("t_s", np.floor, "does not increase"),
    "a leap": ("north_m", lambda c: np.where(np.arange(len(c)) == 7, 1e308, c), "1e.308 in row 8"),
}


@pytest.mark.parametrize("case", NONSENSE)
def test_impossible_values_are_refused_with_the_columns_name(tmp_path: Path, case: str) -> None:
    name, spoil, told = NONSENSE[case]
    table = columns()
    if case == "degrees":  # more than a turn, with a step at north
        table["yaw_rad"] = table["yaw_rad"] + np.linspace(0.0, 9.0, len(table["yaw_rad"]))
    table[name] = spoil(table[name])
    with pytest.raises(BadLogError, match=told) as error:
        read_csv(written(tmp_path, table))
    assert name in str(error.value)


@pytest.mark.parametrize(
    ("missing", "what"),
    [
        (("yaw_rad",), "heading"),
        (("north_m", "east_m"), "position"),
        (("surge_mps",), "speed"),
        (("yaw_rate_radps",), "yaw rate"),
        (("port",), "port"),
    ],
)
def test_a_column_without_values_is_refused(
    tmp_path: Path, missing: tuple[str, ...], what: str
) -> None:
    table = columns()
    empty = dict.fromkeys(missing, np.full(len(table["t_s"]), np.nan))
    with pytest.raises(BadLogError, match=f"{what} has no values"):
        read_csv(written(tmp_path, table | empty))


def test_a_last_line_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    path = written(tmp_path, columns())
    whole, _ = read_csv(path)
    path.write_text(path.read_text() + "99.9,1.5,2")
    cut, _ = read_csv(path)
    assert np.array_equal(whole.motion, cut.motion)


def test_a_log_that_is_given_twice_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, columns())
    other = tmp_path / "other.csv"
    other.symlink_to(path)
    with pytest.raises(BadLogError, match=r"other\.csv: is given twice"):
        read([path, other])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "does not name the columns"),
        ("1,2,3\n4,5,6\n", "does not name the columns"),
        ("t_s,north_m\n1,2\n2,3\n", "no column"),
        ("t_s,north_m\n1,2\n2\n3,4\n5\n", r"log.csv: line 3 has 1 values, for 2 columns"),
        ("t_s;north_m\n1;2\n2;3\n", r"log.csv: the columns must be separated by commas"),
        ("t_s,port\n", "log.csv"),
    ],
)
def test_a_file_that_is_no_table_is_refused(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(BadLogError, match=told):
        read_csv(path)
