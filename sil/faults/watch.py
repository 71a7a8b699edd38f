# SPDX-License-Identifier: MIT
"""Observes the boats while a matrix of faults is sailed; contains the operator who helps."""

from collections.abc import Iterable, Iterator, Sequence

import flotilla
import numpy as np
import numpy.typing as npt
from pymavlink.dialects.v20 import common as mavlink

from sil.faults.rows import Row
from sil.lockstep.batch import Batch
from sil.plant.hull import Array
from sil.wire.heartbeat import FORMATION, HOLD, MANUAL
from sil.wire.mavlink_frames import frames
from sil.wire.operator import Operator, mode_request, next_request

RETRY_S = 0.5  # the operator asks again after this time
_STICKS_S = 0.1
#: Sticks after `home_s`: ahead, then at neutral, then ahead again.
CENTRED_S, AHEAD_S = 2.0, 2.3
States = npt.NDArray[np.uint8]
STATES: dict[str, int] = {name: i for i, name in enumerate(flotilla.STATES)}
#: States in which no thrust may be commanded.
OFF = [STATES[name] for name in ("DISARMED", "HOLD", "FAULT")]


class Watch:
    """The history of each row's boat.

    Its `states` (rows, ticks), the commands to its motors (rows, ticks, 2), and for rows with
    `told` the STATUSTEXT `texts` since the fault began. If a row has an operator, requests are sent
    every half second from the row's `asks_s` on.
    """

    def __init__(self, rows: Sequence[Row], ticks: int) -> None:
        self._rows, self._pilot = rows, Operator()
        self.states: States = np.zeros((len(rows), ticks), np.uint8)
        self.commands: Array = np.zeros((len(rows), ticks, 2))
        self.texts: list[list[str]] = [[] for _ in rows]

    def __call__(self, batch: Batch, members: Sequence[int], tick: int, t_us: int) -> None:
        """Record tick `tick` of these rows."""
        states, t_s = batch.states, 1e-6 * tick * batch.h_us
        for run, member in enumerate(members):
            row = self._rows[member]
            self.states[member, tick] = states[run, row.boat - 1]
            self.commands[member, tick] = batch.command[run * batch.boats + row.boat - 1]
            if row.told and t_s - row.begins_s > -1e-9:
                self.texts[member] += _texts(batch.fleet.sent(batch.row(run, row.boat)))
            late_s = t_s - row.asks_s
            if row.recovery == "operator" and late_s > -1e-9 and _due(late_s, batch.h_us):
                ask(batch, batch.agents(run), states[run].tolist(), t_us)
            if row.hold_s and abs(t_s - row.begins_s - row.hold_s) < 1e-9:
                agent = batch.row(run, row.boat)
                set_mode(batch, agent, HOLD, t_us)
            if row.home_s and t_s - row.begins_s - row.home_s > -1e-9:
                self._drive(batch, run, row, t_s - row.begins_s - row.home_s, t_us)

    def _drive(self, batch: Batch, run: int, row: Row, home_s: float, t_us: int) -> None:
        agent = batch.row(run, row.boat)
        if _due(home_s, batch.h_us, _STICKS_S):
            ahead = 0.0 if CENTRED_S <= home_s + 1e-9 < AHEAD_S else 0.5
            system = int(batch.fleet.parameters(agent)["MAV_SYSID"])
            batch.fleet.hear(agent, self._pilot.sticks(system, ahead), t_us)
        if _due(home_s, batch.h_us):
            ask(batch, [agent], [int(batch.states[run, row.boat - 1])], t_us, MANUAL)


def ask(
    batch: Batch, agents: Iterable[int], states: Sequence[int], t_us: int, mode: int = FORMATION
) -> None:
    """Request the next step towards `mode` for each of these boats that has not reached it."""
    for agent, state in zip(agents, states, strict=True):
        if request := next_request(flotilla.STATES[state], mode):
            batch.fleet.command([agent], t_us, *request)


def set_mode(batch: Batch, agent: int, mode: int, t_us: int) -> None:
    """Send the operator's request for a mode to an agent of the fleet."""
    batch.fleet.command([agent], t_us, *mode_request(mode))


def _texts(sent: bytes) -> Iterator[str]:
    """The STATUSTEXTs among the bytes that a boat sent in a tick."""
    for message_id, _, _, frame in frames(sent):
        if message_id == mavlink.MAVLINK_MSG_ID_STATUSTEXT:
            yield mavlink.MAVLink(None).decode(bytearray(frame)).text


def _due(late_s: float, h_us: int, every_s: float = RETRY_S) -> bool:
    return round(1e6 * late_s) % round(1e6 * every_s) < h_us
