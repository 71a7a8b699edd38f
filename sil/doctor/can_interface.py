# SPDX-License-Identifier: MIT
"""Checks the CAN interface: it exists, is up, at DroneCAN's rate, without errors.

Linux reports rate, state and counters only by netlink: `ip -json -details link show`.
"""

import json
import shutil
import subprocess
from collections.abc import Iterator
from typing import Any

from sil.doctor.boat_file import Boat
from sil.doctor.computer import Computer
from sil.doctor.finding import Finding, bad, doubt, ok

_CAN_TYPE = "280"  # ARPHRD_CAN
_IFF_UP = 1
_BIT_RATE = 1_000_000
_RATE_FILE = "/etc/systemd/network/60-flotilla-can0.network"
_WIRES = (
    "measure the resistance from CAN-H to CAN-L without power: 60 Ω, that is 120 Ω at both ends "
    "and nowhere else; check that all nodes have one bit rate, and the HAT's crystal in "
    "/boot/firmware/config.txt"
)


def can_interface(computer: Computer, boat: Boat) -> Iterator[Finding]:
    """Findings about the bus that need no listening."""
    scheme, _, name = boat.can.partition(":")
    if scheme != "socketcan":
        what = "is a simulated bus: no motor controller hears it"
        yield doubt(boat.can, what, 'set can = "socketcan:can0" in the configuration file')
        return
    folder = f"/sys/class/net/{name}"
    if not computer.at(folder).exists():
        yield bad(
            boat.can,
            "there is no such interface",
            "add the CAN HAT's dtoverlay to /boot/firmware/config.txt, then reboot; "
            "`sudo dmesg | grep -i can` shows what the kernel found",
        )
        return
    if computer.read(f"{folder}/type") != _CAN_TYPE:
        yield bad(boat.can, "is not a CAN interface", "`ip -br link show type can` lists them")
        return
    flags = int(computer.read(f"{folder}/flags") or "0", 16)
    if not flags & _IFF_UP:
        up = f"sudo networkctl reload, or sudo ip link set {name} up type can bitrate {_BIT_RATE}"
        yield bad(boat.can, "is down", up)
        return
    yield from _details(boat.can, details(name))


def details(name: str) -> dict[str, Any]:
    """Netlink's details of a CAN interface; empty if there are none."""
    program = shutil.which("ip")
    if program is None:
        return {}
    words = [program, "-json", "-details", "-statistics", "link", "show", name]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=10)  # noqa: S603
    try:
        told = json.loads(done.stdout)
        return dict(told[0]["linkinfo"])
    except (ValueError, LookupError, TypeError):
        return {}


def _details(where: str, told: dict[str, Any]) -> Iterator[Finding]:
    if told.get("info_kind") == "vcan":
        yield doubt(
            where,
            "is a virtual bus: no motor controller hears it",
            "set can to the HAT's interface",
        )
        return
    data = told.get("info_data", {})
    rate = data.get("bittiming", {}).get("bitrate")
    if rate is None:
        yield doubt(where, "its bit rate is unknown", "apt install iproute2; ip -details link")
    elif rate != _BIT_RATE:
        yield bad(
            where,
            f"runs at {rate:,} bit/s, motor controllers usually at {_BIT_RATE:,}",
            f"BitRate=1M in {_RATE_FILE}, then: sudo networkctl reload",
        )
    else:
        yield ok(where, f"is up, {rate:,} bit/s")
    state = data.get("state", "ERROR-ACTIVE")
    errors = data.get("berr_counter", {})
    counted = f", {errors['tx']} errors sending, {errors['rx']} receiving" if errors else ""
    if state != "ERROR-ACTIVE":
        yield bad(where, f"is {state}{counted}", _WIRES)
    if data.get("restart_ms") == 0:
        remedy = f"RestartSec=100ms in {_RATE_FILE}, then: sudo networkctl reload"
        yield doubt(where, "stays off after too many errors", remedy)
    lost = told.get("info_xstats", {}).get("bus_off", 0)
    if lost:
        yield doubt(where, f"was switched off by errors {lost} times since it came up", _WIRES)
