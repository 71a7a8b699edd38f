# SPDX-License-Identifier: MIT
"""The share of a slow radio that signing boats need: one boat of `diamond`, and eight boats.

All at the firmware's defaults except for the named parameters. The simulated boats do not sign;
13 bytes per frame are added for the signature, which a test with signing boats confirms.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TypedDict

from pymavlink.dialects.v20 import common as mavlink
from rich.console import Group
from rich.table import Table

from sil.lockstep import metrics
from sil.lockstep.recording import MAVLINK_OUT, Recording
from sil.lockstep.world import World
from sil.plant.hull import Array
from sil.results.claims import CLAIMS, PRODUCT
from sil.scenario import scenario
from sil.scenario.scenario import Scenario
from sil.wire.mavlink_frames import frames

BAUD = 57_600
BITS_PER_BYTE = 10  # 8N1
SIGNATURE = 13  # bytes
BOAT = 2  # has a leader that is a boat, and has a follower
RADIO = 1  # number of the radio's link

# One boat: the target share, and parameters that meet it where the defaults do not.
TARGET_SHARE = 0.4
SELDOM = {"SR_SLOW": 0.25}
ONE_S = 60.0
# Eight boats in a line, all within radio range. Of the profiles that leave a tenth of the radio
# free, the one whose boats never coast at 10 % packet loss; all have the same RMS.
BOATS = 8
PROFILE = {"SR_STATE": 1.5, "SR_SLOW": 0.1, "FS_LEADER_S": 4.0}
EIGHT_SHARE, EIGHT_RMS_M = 0.9, 0.1

# Messages that the wheel's dialect lacks.
_NAMES = {
    290: "ESC_INFO",
    291: "ESC_STATUS",
    436: "CURRENT_MODE",
    53100: "FORMATION_REFERENCE",
    53101: "FORMATION_FUTURE",
}


class Radio(TypedDict):
    """Signed bytes per second by message, their share of the radio, and `rms_m`.

    `rms_m`: the worst boat's RMS distance from its slot over the last third of the run.
    """

    bytes_per_s: dict[str, float]
    share: float
    rms_m: float


def measure(folder: Path) -> dict[str, Radio]:
    """All columns of the table, by name; recordings are written to `folder`."""
    return {
        "one boat": one(folder, {}),
        "profile 1": one(folder, SELDOM),
        "eight boats": eight(folder, {}),
        "profile 8": eight(folder, PROFILE),
    }


def one(folder: Path, parameters: Mapping[str, float]) -> Radio:
    """Measure boat 2 of `diamond`."""
    chosen = _at_the_defaults("diamond", [f"duration_s={ONE_S}"])
    return _sailed(chosen, parameters, folder, [BOAT])


def eight(folder: Path, parameters: Mapping[str, float], *overrides: str) -> Radio:
    """Measure eight boats of `line20`, without the virtual leader's own messages."""
    line = _at_the_defaults("line20", overrides)
    chosen = line.model_copy(update={"boat": line.boat[:BOATS]})
    return _sailed(chosen, parameters, folder, range(1, BOATS + 1))


def _at_the_defaults(name: str, overrides: Iterable[str]) -> Scenario:
    return scenario.load(name, [*CLAIMS[name].settings(PRODUCT), *overrides], PRODUCT)


def _sailed(
    chosen: Scenario, parameters: Mapping[str, float], folder: Path, boats: Iterable[int]
) -> Radio:
    path = folder / "radio.bin"
    run = World(chosen, dict(parameters)).run(path, lambda _: None)
    rates = {n: b / chosen.duration_s for n, b in _said(path, boats, chosen.duration_s)}
    share = sum(rates.values()) * BITS_PER_BYTE / BAUD
    return {"bytes_per_s": rates, "share": share, "rms_m": _worst_rms_m(run.trace["error"])}


def _said(path: Path, boats: Iterable[int], sailed_s: float) -> list[tuple[str, int]]:
    """Bytes that boats send by radio after the release, by message, most first."""
    ports = {(boat << 8) + MAVLINK_OUT + RADIO for boat in boats}
    recording = list(Recording(path))
    released_us = recording[-1][0] - round(1e6 * sailed_s)
    said: Counter[str] = Counter()
    for t_us, port, data in recording:
        if port in ports and t_us > released_us:
            for message_id, _, _, frame in frames(data):
                known = mavlink.mavlink_map.get(message_id)
                name = known.msgname if known else _NAMES.get(message_id, str(message_id))
                said[name] += len(frame) + SIGNATURE
    return said.most_common()


def _worst_rms_m(error: Array) -> float:
    distances = metrics.distances(error)
    return float((distances[2 * len(distances) // 3 :] ** 2).mean(axis=0).max() ** 0.5)


def pasted(parameters: Mapping[str, float]) -> str:
    """Parameters as options of flotillad and `flotilla run`."""
    return " ".join(f"--param {name}={value:g}" for name, value in parameters.items())


def table(radios: Mapping[str, Radio]) -> Group:
    """The figures as tables for the terminal."""
    title = f"boats that sign, on a radio of {BAUD:,} Bd: bytes per second"
    out = Table("message", title=title, title_justify="left")
    for name in radios:
        out.add_column(name, justify="right")
    shown = radios.values()
    for message in max((radio["bytes_per_s"] for radio in shown), key=len):
        out.add_row(message, *(f"{radio['bytes_per_s'].get(message, 0.0):.0f}" for radio in shown))
    out.add_section()
    out.add_row("share of the radio", *(f"{100 * radio['share']:.1f} %" for radio in shown))
    out.add_row("worst RMS (m)", *(f"{radio['rms_m']:.3f}" for radio in shown))
    return Group(
        out,
        f"targets: one boat {100 * TARGET_SHARE:.0f} %; eight in a line {100 * EIGHT_SHARE:.0f} % "
        f"and {EIGHT_RMS_M:g} m with a profile",
        f"profile 1: {pasted(SELDOM)}",
        f"profile 8: {pasted(PROFILE)}",
    )
