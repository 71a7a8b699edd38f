# SPDX-License-Identifier: MIT
"""Checks the computer itself: clock, disk, memory, speed, supply."""

import os
import time
from collections.abc import Iterator, Sequence

from sil.doctor.computer import Computer
from sil.doctor.finding import Finding, bad, doubt, ok

_RELEASED_S = 1_767_225_600  # 2026-01-01: no boat has run this program before
_LEAST_DISK_MB, _LITTLE_DISK_MB = 100, 2_000
_LEAST_MEMORY_MB = 100
_HOT_C = 80.0
#: Files that exist while a program sets the clock over the network.
_SYNCHRONISED = (
    "/run/systemd/timesync/synchronized",
    "/run/chrony/chronyd.pid",
    "/run/ntpd.pid",
)
_THROTTLED = "/sys/devices/platform/soc/soc:firmware/get_throttled"
_NOW, _EARLIER = 0xF, 0xF0000


def machine(
    computer: Computer, folders: Sequence[str], now_s: float | None = None
) -> Iterator[Finding]:
    """Findings about the computer.

    `folders`: those that the boat writes to; `now_s`: Unix time, by default the clock's.
    """
    yield from _clock(computer, time.time() if now_s is None else now_s)
    for folder in dict.fromkeys(folders):
        yield from _disk(computer, folder)
    yield from _memory(computer)
    yield from _speed(computer)
    yield from _supply(computer)


def _clock(computer: Computer, now_s: float) -> Iterator[Finding]:
    told = time.strftime("%Y-%m-%d %H:%M", time.gmtime(now_s))
    if now_s < _RELEASED_S:
        yield bad(
            "clock",
            f"is wrong: {told} UTC",
            "connect a network until `timedatectl` reports synchronized, or fit a real-time clock "
            "with a battery; until then signed MAVLink uses the navigation unit's SYSTEM_TIME",
        )
    elif not any(computer.at(path).exists() for path in _SYNCHRONISED):
        yield doubt(
            "clock",
            f"is not synchronised over the network: {told} UTC",
            "sudo timedatectl set-ntp true; without a network its drift affects only the logs",
        )
    else:
        yield ok("clock", f"is synchronised over the network: {told} UTC")


def _disk(computer: Computer, folder: str) -> Iterator[Finding]:
    path = computer.at(folder)
    while not path.exists() and path != path.parent:
        path = path.parent
    free_mb = os.statvfs(path).f_bavail * os.statvfs(path).f_frsize / 1e6
    told = f"{free_mb:,.0f} MB are free"
    if free_mb < _LEAST_DISK_MB:
        yield bad(folder, told, "remove old logs there; on a full disk no parameters are saved")
    elif free_mb < _LITTLE_DISK_MB:
        yield doubt(folder, told, "logs take up to 2 GB: remove old ones, or use a larger card")
    else:
        yield ok(folder, told)


def _memory(computer: Computer) -> Iterator[Finding]:
    for line in (computer.read("/proc/meminfo") or "").splitlines():
        if line.startswith("MemAvailable:"):
            free_mb = int(line.split()[1]) / 1e3
            told = f"{free_mb:,.0f} MB are available"
            if free_mb < _LEAST_MEMORY_MB:
                remedy = (
                    "`ps aux --sort=-rss | head` lists the largest programs; stop unneeded ones"
                )
                yield doubt("memory", told, remedy)
            else:
                yield ok("memory", told)


def _speed(computer: Computer) -> Iterator[Finding]:
    governors = {
        computer.read(path.relative_to(computer.root))
        for path in computer.at("/sys/devices/system/cpu").glob("cpu*/cpufreq/scaling_governor")
    }
    if "powersave" in governors:
        yield doubt(
            "processor",
            "is kept at its lowest speed (governor powersave)",
            "echo ondemand | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor",
        )
    zones = [
        float(text) / 1000
        for path in computer.at("/sys/class/thermal").glob("thermal_zone*/temp")
        if (text := computer.read(path.relative_to(computer.root))) and text.lstrip("-").isdigit()
    ]
    if zones and max(zones) > _HOT_C:
        yield doubt(
            "processor",
            f"is hot: {max(zones):.0f} °C",
            "give its box a metal lid, or a heat sink to the hull: it slows down at 85 °C",
        )
    elif zones:
        yield ok("processor", f"{max(zones):.0f} °C")


def _supply(computer: Computer) -> Iterator[Finding]:
    text = computer.read(_THROTTLED)
    if text is None:
        return
    bits = int(text, 16)
    remedy = (
        "use a supply of 5.1 V and 3 A, with short thick wires, whose voltage holds while the "
        "motors start"
    )
    if bits & _NOW:
        yield bad("supply", "the voltage is too low or the processor is throttled now", remedy)
    elif bits & _EARLIER:
        yield doubt(
            "supply",
            "the voltage was too low or the processor was throttled since boot",
            remedy,
        )
    else:
        yield ok("supply", "the voltage was never too low since boot")
