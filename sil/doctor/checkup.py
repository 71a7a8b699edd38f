# SPDX-License-Identifier: MIT
"""All examinations of the doctor, in the order in which a boat needs them; the verdict."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from sil.doctor import boat_file, installation
from sil.doctor.boat_file import Boat
from sil.doctor.bus_nodes import bus_nodes
from sil.doctor.can_interface import can_interface
from sil.doctor.computer import Computer
from sil.doctor.finding import Finding, Level
from sil.doctor.machine_checks import machine
from sil.doctor.mavlink_links import links


def examine(computer: Computer, config: str, seconds: float) -> Iterator[Finding]:
    """Yield findings as they come; `seconds`: time to listen to each bus."""
    boat, found = boat_file.read(computer, config)
    yield from found
    written = [boat.state_dir, boat.log] if boat else [Boat.state_dir]
    yield from machine(computer, [folder for folder in written if folder])
    yield from installation.service(computer)
    if boat is None:
        return
    yield from installation.groups(computer, boat)
    yield from installation.folders(computer, boat)
    yield from installation.parameters(computer, boat)
    yield from installation.signing_key(computer, boat)
    interface = list(can_interface(computer, boat))
    yield from interface
    usable = not any(finding.level is Level.BAD for finding in interface)
    with ThreadPoolExecutor(2) as pool:  # both threads only wait
        bus = pool.submit(lambda: list(bus_nodes(boat, seconds)) if usable else [])
        radio = pool.submit(lambda: list(links(computer, boat, seconds)))
        yield from bus.result()
        yield from radio.result()


def verdict(findings: Sequence[Finding]) -> str:
    """The verdict: the first line of the report."""
    bad = sum(finding.level is Level.BAD for finding in findings)
    doubts = sum(finding.level is Level.DOUBT for finding in findings)
    if bad:
        things = "one thing keeps" if bad == 1 else f"{bad} things keep"
        return f"not ready: {things} this boat from sailing; {doubts} more to look at"
    return f"ready, {doubts} to look at" if doubts else "ready: nothing wrong was found"


def lines(findings: Sequence[Finding]) -> Iterator[str]:
    """The report as text: the verdict, then the worst first."""
    yield verdict(findings)
    for level, heading in (
        (Level.BAD, "wrong"),
        (Level.DOUBT, "to look at"),
        (Level.OK, "in order"),
    ):
        those = [finding for finding in findings if finding.level is level]
        if those:
            yield ""
            yield f"{heading}:"
        for finding in those:
            yield f"  {finding.where}: {finding.what}"
            if finding.remedy:
                yield f"      {finding.remedy}"


def as_json(findings: Sequence[Finding]) -> dict[str, Any]:
    """The report as JSON values, for a program."""
    return {
        "verdict": verdict(findings),
        "ready": not any(finding.level is Level.BAD for finding in findings),
        "findings": [
            {"level": str(f.level), "where": f.where, "what": f.what, "remedy": f.remedy}
            for f in findings
        ],
    }
