# SPDX-License-Identifier: MIT
"""What is seen of the boats while a matrix of faults is sailed, and the operator who helps."""

from collections.abc import Sequence

import flotilla
import numpy as np
import numpy.typing as npt
from pymavlink.dialects.v20 import common as mavlink  # type: ignore[import-untyped]

from sil.batch import Batch
from sil.faults.rows import Row
from sil.plant.hull import Array
from sil.wire.heartbeat import FORMATION, HOLD

_RETRY_S = 0.5
_CUSTOM_MODE = float(mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
States = npt.NDArray[np.uint8]
STATES: dict[str, int] = {name: i for i, name in enumerate(flotilla.STATES)}


class Watch:
    """Of each row its boat's `states` (rows, ticks), and what its motors are told (rows, ticks, 2).

    The operator asks every half a second from a fault's end on, where a row has one.
    """

    def __init__(self, rows: Sequence[Row], ticks: int) -> None:
        self._rows = rows
        self.states: States = np.zeros((len(rows), ticks), np.uint8)
        self.commands: Array = np.zeros((len(rows), ticks, 2))

    def __call__(self, batch: Batch, members: Sequence[int], tick: int, t_us: int) -> None:
        """Tick `tick` of those rows has been."""
        states, t_s = batch.states, 1e-6 * tick * batch.h_us
        for run, member in enumerate(members):
            row = self._rows[member]
            self.states[member, tick] = states[run, row.boat - 1]
            self.commands[member, tick] = batch.command[run * batch.boats + row.boat - 1]
            late_s = t_s - row.ends_s
            if row.recovery == "operator" and late_s > -1e-9 and _due(late_s, batch.h_us):
                ask(batch, run, states[run].tolist(), t_us)
            if row.hold_s and abs(t_s - row.begins_s - row.hold_s) < 1e-9:
                agent = batch.row(run, row.boat)
                set_mode(batch, agent, HOLD, t_us)


def ask(batch: Batch, run: int, states: Sequence[int], t_us: int) -> None:
    """The next step into FORMATION for each of a run's boats that is not."""
    for agent, state in zip(batch.agents(run), states, strict=True):
        if state == STATES["FAULT"]:
            batch.fleet.command([agent], t_us, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (0.0,))
        elif state == STATES["DISARMED"]:
            batch.fleet.command([agent], t_us, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (1.0,))
        elif state == STATES["HOLD"]:
            set_mode(batch, agent, FORMATION, t_us)


def set_mode(batch: Batch, agent: int, mode: int, t_us: int) -> None:
    """The operator asks an agent of the fleet for a mode."""
    batch.fleet.command([agent], t_us, mavlink.MAV_CMD_DO_SET_MODE, (_CUSTOM_MODE, float(mode)))


def _due(late_s: float, h_us: int) -> bool:
    return round(1e6 * late_s) % round(1e6 * _RETRY_S) < h_us
