# SPDX-License-Identifier: MIT
"""Judges the senders on the boat's MAVLink links: their ids, rates, latencies and signatures."""

from collections.abc import Iterator, Sequence

from sil.doctor.boat_file import Boat, Link
from sil.doctor.finding import Finding, bad, doubt, ok
from sil.doctor.heard import Heard, Sender

_PLACES = ("LOCAL_POSITION_NED", "GLOBAL_POSITION_INT")
_LEAST_HZ = 9.0  # least rate of a unit that is set to 10 Hz
_LATE_S = 0.2
_DAMAGED = 0.05
_UNIT = "check its cable and baud rate; its MAVLink output must be on (firmware/docs/AUTOPILOT.md)"


def judge_links(boat: Boat, heard: Sequence[tuple[Link, Heard]]) -> Iterator[Finding]:
    """Findings about each link, for a boat whose flotillad does not run."""
    for link, one in heard:
        yield from _noise(link, one)
        yield from _signatures(boat, link, one)
    yield from _namesake(boat, heard)


def judge_senders(
    boat: Boat, heard: Sequence[tuple[Link, Heard]], seconds: float
) -> Iterator[Finding]:
    """Findings about the navigation unit and the leader, over all links together."""
    yield from _unit(boat, heard, seconds)
    leader = round(boat.parameters.get("FORM_LEADER", 0))
    if not any(sender[0] == leader for _, one in heard for sender in one.counts):
        yield doubt(
            "radio",
            f"the leader, system {leader} (FORM_LEADER), is not heard",
            "check that it is switched on, its system id, and the radio's pairing and channel",
        )


def _noise(link: Link, heard: Heard) -> Iterator[Finding]:
    if heard.bytes == 0:
        yield doubt(link.address, "nothing is heard", "check the power and address of the sender")
    elif heard.damaged > _DAMAGED * heard.bytes:
        share = 100.0 * heard.damaged / heard.bytes
        remedy = "check the cable and both baud rates; no other program may read the line"
        yield bad(link.address, f"{share:.0f} % of the received bytes are not MAVLink", remedy)
    else:
        systems = sorted({sender[0] for sender in heard.counts})
        yield ok(link.address, f"systems heard: {', '.join(map(str, systems))}")


def _signatures(boat: Boat, link: Link, heard: Heard) -> Iterator[Finding]:
    for sender, unsigned in sorted(heard.unsigned.items()):
        total = sum(heard.counts[sender].values())
        if link.signing == "required" and unsigned:
            remedy = (
                "give it the fleet's key; if it is on a cable, append ,signing=off to the address"
            )
            yield bad(
                link.address, f"{_name(sender)} does not sign, but signatures are required", remedy
            )
        elif not boat.signing_key and unsigned < total:
            remedy = "copy the fleet's key to the boat, and set signing-key to its path"
            yield doubt(link.address, f"{_name(sender)} signs, but this boat has no key", remedy)


def _name(sender: Sender) -> str:
    return f"system {sender[0]} component {sender[1]}"


def _namesake(boat: Boat, heard: Sequence[tuple[Link, Heard]]) -> Iterator[Finding]:
    own = (boat.system, round(boat.parameters.get("MAV_COMPID", 1)))
    companion = boat.parameters.get("MAV_IDENTITY", 0) == 1
    for link, one in heard:
        if own in _boats(one) and not companion:
            yield bad(
                link.address,
                f"another boat has this boat's system id {own[0]}",
                "give each boat its own MAV_SYSID; beside an ArduPilot, set MAV_IDENTITY to 1",
            )


def _boats(heard: Heard) -> set[Sender]:
    """Senders of both a heartbeat and messages that only a boat's control program sends."""
    ours = ("POSITION_TARGET_LOCAL_NED", "NAV_CONTROLLER_OUTPUT")
    return {
        sender
        for sender, names in heard.counts.items()
        if names["HEARTBEAT"] and any(names[name] for name in ours)
    }


def _unit(boat: Boat, heard: Sequence[tuple[Link, Heard]], seconds: float) -> Iterator[Finding]:
    units = [
        (max(names[place] for place in _PLACES) / seconds, link, one, sender)
        for link, one in heard
        for sender, names in one.counts.items()
        if sender[0] == boat.system and any(names[place] for place in _PLACES)
    ]
    if not units:
        what = f"system {boat.system} (MAV_SYSID) sends no position"
        others = sorted({sender[0] for _, one in heard for sender in one.counts} - {boat.system})
        told = f"; systems heard: {', '.join(map(str, others))}" if others else ""
        yield bad("navigation unit", what + told, f"{_UNIT}; its system id must be the boat's")
        return
    rate_hz, link, one, sender = max(units, key=lambda unit: unit[0])
    if rate_hz < _LEAST_HZ:
        remedy = "set its rate to 10 Hz or more (ArduPilot: SRn_POSITION, SRn_EXTRA1 of that port)"
        yield doubt(link.address, f"navigation unit: {rate_hz:.1f} positions per second", remedy)
    else:
        yield ok(link.address, f"navigation unit: {rate_hz:.0f} positions per second")
    if not one.counts[sender]["ATTITUDE"]:
        yield bad(
            link.address,
            "the navigation unit sends no ATTITUDE",
            "set it to send ATTITUDE at 10 Hz or more",
        )
    late_s = one.latency_s(sender)
    if late_s is None and boat.parameters.get("NAV_LAG_S", -1) < 0:
        remedy = "set NAV_LAG_S, or turn the boat in MANUAL until the delay is measured"
        yield doubt(
            link.address,
            "the navigation unit does not answer TIMESYNC: its delay is unknown",
            remedy,
        )
    elif late_s is not None:
        yield latency(link.address, "navigation unit", late_s)


def latency(where: str, who: str, late_s: float) -> Finding:
    """Finding about the latency of messages of `who`."""
    told = f"{who}: a message takes {1000 * late_s:.0f} ms to arrive"
    if late_s > _LATE_S:
        remedy = (
            "use a faster link, send fewer messages on it, or remove routers, USB hubs and radios "
            "on the way"
        )
        return doubt(where, told, remedy)
    return ok(where, told)
