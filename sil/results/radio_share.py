# SPDX-License-Identifier: MIT
"""The share of a slow radio that signing boats need: one boat of `diamond`, and eight boats.

All at the firmware's defaults except for the named parameters. The one boat is fed its recorded
input again, signs, and is limited to the radio's rate, as `flotillad` limits a serial line. The
eight simulated boats do not sign: 13 bytes per frame are added for the signature.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypedDict

from pymavlink.dialects.v20 import common as mavlink
from rich.console import Group
from rich.table import Table

from sil.lockstep import metrics
from sil.lockstep.recording import MAVLINK_OUT, Recording
from sil.lockstep.replay import ticks
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

TARGET_SHARE = 0.4  # of one boat
LIMIT_BPS = BAUD * 4 // 5 // BITS_PER_BYTE  # of a serial line
KEY = bytes(range(32))
_SIGNING_US = 1_790_000_000_000_000  # since 1970
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
        "one boat": one(folder),
        "no limit": one(folder, limit_Bps=0),
        "eight boats": eight(folder, {}),
        "profile 8": eight(folder, PROFILE),
    }


def one(folder: Path, limit_Bps: int = LIMIT_BPS) -> Radio:
    """Measure boat 2 of `diamond`, its link limited to that rate; 0: no limit."""
    chosen = _at_the_defaults("diamond", [f"duration_s={ONE_S}"])
    path = folder / "radio.bin"
    others = {"SR_SLOW": 0.25} if limit_Bps else {}  # they ask as seldom as on such a radio
    run = World(chosen, others).run(path, lambda _: None)
    recording = Recording(path)
    released_us = list(recording)[-1][0] - round(1e6 * ONE_S)
    said: Counter[str] = Counter()
    for t_us, frame in frames_of(recording, signs=True, limit_Bps=limit_Bps):
        if t_us > released_us:
            said[_name(frame)] += len(frame)
    return _radio(said, ONE_S, run.trace["error"])


def frames_of(
    recording: Recording, signs: bool = False, limit_Bps: int = 0
) -> Iterator[tuple[int, bytes]]:
    """Times in us, and frames that boat 2 sends by radio when it is fed the recording's input.

    Its own SR_SLOW is the default.
    """
    header = recording.header["boats"][BOAT - 1]
    parameters = {k: v for k, v in header["parameters"].items() if k != "SR_SLOW"}

    def settings(boat: Any) -> None:
        boat.limit_link(RADIO, limit_Bps)
        if signs:
            boat.secure(KEY, _SIGNING_US)
            boat.set_signing(RADIO, "accept")

    for t_us, out in ticks(recording, BOAT, header | {"parameters": parameters}, settings):
        said = dict(out.mavlink).get(RADIO, b"")
        yield from ((t_us, frame) for *_, frame in frames(said))


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
    said = _said(path, boats, chosen.duration_s)
    return _radio(said, chosen.duration_s, run.trace["error"])


def _radio(said: Counter[str], sailed_s: float, error: Array) -> Radio:
    rates = {name: count / sailed_s for name, count in said.most_common()}
    share = sum(rates.values()) * BITS_PER_BYTE / BAUD
    return {"bytes_per_s": rates, "share": share, "rms_m": _worst_rms_m(error)}


def _said(path: Path, boats: Iterable[int], sailed_s: float) -> Counter[str]:
    """Bytes that boats send by radio after the release, by message, with signatures."""
    ports = {(boat << 8) + MAVLINK_OUT + RADIO for boat in boats}
    recording = list(Recording(path))
    released_us = recording[-1][0] - round(1e6 * sailed_s)
    said: Counter[str] = Counter()
    for t_us, port, data in recording:
        if port in ports and t_us > released_us:
            for *_, frame in frames(data):
                said[_name(frame)] += len(frame) + SIGNATURE
    return said


def _name(frame: bytes) -> str:
    message_id = int.from_bytes(frame[7:10], "little")
    known = mavlink.mavlink_map.get(message_id)
    return known.msgname if known else _NAMES.get(message_id, str(message_id))


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
        f"one boat: its link is limited to {LIMIT_BPS} bytes per second, as a serial line's is",
        f"profile 8: {pasted(PROFILE)}",
    )
