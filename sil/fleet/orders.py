# SPDX-License-Identifier: MIT
"""Sends orders to boats, repeats each until its boat has answered, and explains the answers.

An answer (COMMAND_ACK) names neither ARM or DISARM nor the mode: it may be a late answer to an
earlier order. Orders that stop boats are therefore repeated until a HEARTBEAT shows it.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.lead import root
from sil.fleet.station import Station
from sil.fleet.tables import StopTable
from sil.wire.operator import DISARM, Request

PATIENCE_S, STOP_PATIENCE_S = 6.0, 8.0
DISCOVERY_S = 2.5

_RETRY_S, _STOP_RETRY_S = 0.4, 0.2
_REASONS_S, _NEWS_S = 1.2, 0.3
_WHY = ("PreArm: ", "Refused: ")
_FAULTS = {
    mavlink.MAV_RESULT_TEMPORARILY_REJECTED: "refused",
    mavlink.MAV_RESULT_DENIED: "denied",
    mavlink.MAV_RESULT_UNSUPPORTED: "command not supported",
    mavlink.MAV_RESULT_FAILED: "failed",
}
_ACCEPTED: int = mavlink.MAV_RESULT_ACCEPTED
_UNSHOWN: int = mavlink.MAV_RESULT_IN_PROGRESS  # answered, but no HEARTBEAT shows it yet

#: The states of a boat that is disarmed, and of one whose propellers rest.
IS_DISARMED = ("DISARMED", "FAULT")
RESTS = ("HOLD", *IS_DISARMED)

Order = Callable[[int, int, int], mavlink.MAVLink_message]
"""Makes the message to a system and component for the nth transmission, counted from 0."""


class Answer(NamedTuple):
    """A boat's answer: its result and its texts; without a result, it did not answer.

    `only_listed`: the station has not heard the boat; a table that another boat passed on lists it.
    """

    system: int
    result: int | None
    said: tuple[str, ...]
    only_listed: bool = False

    @property
    def accepted(self) -> bool:
        """Whether the boat accepted the order."""
        return self.result == _ACCEPTED


def long(request: Request) -> Order:
    """An order that sends a COMMAND_LONG."""
    command, params = request
    seven = (*params, *(0.0,) * (7 - len(params)))

    def message(system: int, component: int, count: int) -> mavlink.MAVLink_message:
        return mavlink.MAVLink_command_long_message(
            system, component, command, min(count, 255), *seven
        )

    return message


def go_to(latitude: int, longitude: int) -> Order:
    """An order to sail to a place (degE7) in GUIDED, and wait there."""

    def message(system: int, component: int, count: int) -> mavlink.MAVLink_message:  # noqa: ARG001
        changes_mode, same_speed = 1.0, -1.0
        return mavlink.MAVLink_command_int_message(
            system,
            component,
            mavlink.MAV_FRAME_GLOBAL_INT,
            mavlink.MAV_CMD_DO_REPOSITION,
            0,
            0,
            *(same_speed, changes_mode, 0.0, 0.0),
            *(latitude, longitude, 0.0),
        )

    return message


class _Sent(NamedTuple):
    """A command, when it was first sent, and the states of which one must follow; none: any."""

    command: int
    since_s: float
    states: Collection[str]


def carry_out(
    station: Station, order: Order, systems: Sequence[int], states: Collection[str] = ()
) -> list[Answer]:
    """Send the order to each system until it answers, for at most 6 s; then listen for reasons.

    With `states`, until its HEARTBEAT shows one of these after its answer.
    """
    sent = _Sent(order(0, 0, 0).command, station.now_s(), states)
    counts = dict.fromkeys(systems, 0)

    def open_ones() -> list[int]:
        return [s for s in counts if _result(station, s, sent) in (None, _UNSHOWN)]

    while station.now_s() - sent.since_s < PATIENCE_S and open_ones():
        for system in leader_last(station, open_ones()):
            station.say(order(system, station.component(system), counts[system]), system)
            counts[system] += 1
        station.run(_RETRY_S, lambda: not open_ones())
    results = [_result(station, system, sent) for system in systems]
    refused = any(result not in (None, _ACCEPTED) for result in results)
    station.run(_REASONS_S if refused else _NEWS_S)
    return [
        Answer(system, result, _said(station, system, sent.since_s))
        for system, result in zip(systems, results, strict=True)
    ]


def stop(station: Station, named: Sequence[int]) -> list[Answer]:
    """Disarm every boat that is heard and every boat named, each directly and by every link.

    Addresses all components, because a boat that is not heard may be an autopilot's companion.
    Begins when the first boat is heard, and waits 2.5 s for others. If boats report a fleet's
    table, also sends a table that stops all of its members; boats pass it on. It also lists, and
    orders to stop, the members of every table that boats have passed on, and boats that sign with
    the station's key at another time: they obey a stop whatever its age.
    """
    since_s = station.now_s()
    sent = _Sent(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, since_s, IS_DISARMED)
    order, table = long(DISARM), StopTable(station)
    count = 0

    def everyone() -> list[int]:
        return sorted({*named, *station.boats(), *_listed(station), *station.late_s})

    def open_ones() -> list[int]:
        return [s for s in everyone() if _result(station, s, sent) != _ACCEPTED]

    def is_over() -> bool:
        return station.now_s() - since_s >= DISCOVERY_S and not open_ones()

    while station.now_s() - since_s < STOP_PATIENCE_S and not is_over():
        known = everyone()
        for system in leader_last(station, open_ones()):
            station.say(order(system, mavlink.MAV_COMP_ID_ALL, count))
        # A boat that has not answered by now may really hold a table with a doubtful epoch.
        late = station.now_s() - since_s >= DISCOVERY_S
        table.send(everyone(), open_ones() if late else ())
        count += 1
        station.run(_STOP_RETRY_S, lambda known=known: everyone() != known or is_over())  # type: ignore[misc]
    heard = {system for system, kind in _kinds(station).items() if kind is not None}
    unheard = _listed(station) - heard - {*named}
    return [
        Answer(
            system,
            _result(station, system, sent),
            _said(station, system, since_s),
            system in unheard,
        )
        for system in everyone()
    ]


def _result(station: Station, system: int, sent: _Sent) -> int | None:
    """A boat's result; None if it has not answered, `_UNSHOWN` if no later HEARTBEAT shows it.

    A boat whose HEARTBEATs never arrive is believed: others forward its answers, but no broadcasts.
    """
    about = system, sent.command
    acks = [
        ack
        for ack in station.acks
        if (ack.system, ack.command) == about and ack.at_s > sent.since_s
    ]
    if not acks:
        return None
    if not sent.states:
        return acks[0].result
    shown = station.shown.get(system)
    if shown is None or (shown.at_s > acks[0].at_s and shown.state in sent.states):
        return acks[-1].result
    return _UNSHOWN


def _listed(station: Station) -> set[int]:
    """Members of the heard tables that are not known as boats; without virtual leaders."""
    virtual = {system for system, kind in _kinds(station).items() if kind == "leader"}
    return station.table().places.keys() - virtual - {*station.boats(), station.system}


def _kinds(station: Station) -> dict[int, str | None]:
    return {system: vessel.kind for system, vessel in station.fleet.systems.items()}


def leader_last(station: Station, systems: Iterable[int]) -> list[int]:
    """Sort systems so that the leader is last: then nobody takes over from a stopped leader."""
    top = root(station)
    return sorted(systems, key=lambda system: (system == top, system))


def tell(answer: Answer, held: Iterable[str], signs: bool) -> str:
    """Explain why a boat did not execute its order.

    `held`: the reasons that keep it from sailing; `signs`: it signs, and the station has no key.
    """
    if answer.only_listed:
        return "not heard, known only from the fleet table"
    if answer.result is None:
        remedy = ": it signs its messages, use --key FILE" if signs else ""
        return f"no answer{remedy}"
    if answer.result == _UNSHOWN:
        return "it answers, but no HEARTBEAT shows that it has obeyed"
    fault = _FAULTS.get(answer.result, f"result {answer.result}")
    reasons = [text.partition(": ")[2] for text in answer.said if text.startswith(_WHY)]
    reasons = reasons or ["; ".join(held)]
    if answer.result == mavlink.MAV_RESULT_DENIED and not any(reasons):
        reasons = [
            "a boat whose MAV_GCS_SYSID is set obeys only that system id: use it with --station"
        ]
    return ": ".join(filter(None, [fault, "; ".join(dict.fromkeys(reasons))]))


def _said(station: Station, system: int, since_s: float) -> tuple[str, ...]:
    heard = [each.text for each in station.texts if each.system == system and each.at_s >= since_s]
    return tuple(dict.fromkeys(heard))
