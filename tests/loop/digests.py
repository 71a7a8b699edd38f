# SPDX-License-Identifier: MIT
"""Digests of all output of boats, to compare two builds of the firmware.

    python -m tests.loop.digests > before.txt     # the same later, then `diff` the two

One line for each scenario, law and scalar, and one for each of 1,000 random histories: a boat that
receives states, commands, sticks, ESCs and garbage in random order. Equivalent builds
print equal lines.
"""

import argparse
import hashlib
import itertools
import random
from typing import get_args

import flotilla
from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console
from rich.progress import track

from sil.lockstep.world import Run, sail
from sil.scenario import scenario
from sil.scenario.law import LAWS
from sil.scenario.sections import Scalar
from sil.wire.esc_node import EscNode

SCENARIOS = sorted(path.stem for path in scenario.FOLDER.glob("*.toml"))
HISTORIES = 1000
TICK_US = 10_000
OWN, LEADER, OPERATOR = 1, 100, 255
COMMANDS = (
    (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (1.0,)),
    (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (0.0,)),
    (mavlink.MAV_CMD_DO_SET_MODE, (1.0, 0.0)),
    (mavlink.MAV_CMD_DO_SET_MODE, (1.0, 4.0)),
    (mavlink.MAV_CMD_DO_SET_MODE, (1.0, 6.0)),
    (mavlink.MAV_CMD_DO_MOTOR_TEST, (1.0, 0.0, 20.0, 1.0)),
    (mavlink.MAV_CMD_DO_FLIGHTTERMINATION, (1.0,)),
    (mavlink.MAV_CMD_REQUEST_MESSAGE, (33.0,)),
)


def of_scenarios(seconds: float) -> list[str]:
    """Digests of each scenario's first `seconds`, with both laws and all scalars."""
    cases = list(itertools.product(SCENARIOS, LAWS, get_args(Scalar)))
    lines = []
    for name, law, scalar in track(cases, console=Console(stderr=True)):
        told = scenario.load(name, [f"scalar={scalar}"], law)
        short = told.model_copy(update={"duration_s": min(seconds, told.duration_s)})
        end: object
        try:
            (run,) = sail([short], {}, digest=True)
            end = run.digest if isinstance(run, Run) else run
        except ValueError as error:
            end = error  # a fleet too large for a recording
        lines.append(f"{name} {law} {scalar}: {end}")
    return lines


class History:
    """A boat, and others around it that send at random."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        pick = self.random
        self.boat = flotilla.Boat(
            {
                "FORM_OFS_N": pick.uniform(-5.0, 5.0),
                "FORM_OFS_E": pick.uniform(-5.0, 5.0),
                "FORM_FRAME": float(pick.randrange(2)),
                "LAW_REF": float(pick.randrange(2)),
                "FS_SEP_M": pick.choice([0.0, 2.0]),
                "FS_GCS_S": pick.choice([0.0, 1.0]),
                "NAV_LAG_S": 0.0,  # nobody answers TIMESYNC
                "FORM_LAG_S": 0.0,
            },
            links=2,
            scalar=pick.choice(get_args(Scalar)),
        )
        self.senders = {
            who: mavlink.MAVLink(None, srcSystem=who[0], srcComponent=who[1])
            for who in ((OWN, 220), (OWN, 197), (LEADER, 1), (7, 1), (OPERATOR, 190))
        }
        self.escs = [EscNode(21 + side, side) for side in range(2)]

    def state(self, who: tuple[int, int], t_us: int) -> bytes:
        """A random state message."""
        pick, mav = self.random, self.senders[who]
        x = 0.4e-6 * t_us + pick.gauss(0.0, 0.01) - (2.0 if who[0] == OWN else 0.0)
        ms = t_us // 1000
        messages = [
            mav.attitude_encode(ms, 0.0, 0.0, 0.8 + pick.gauss(0.0, 0.01), 0.0, 0.0, 0.0),
            mav.local_position_ned_encode(ms, x, x, 0.0, 0.4, 0.4, 0.0),
        ]
        if pick.random() < 0.1:
            messages.append(mav.gps_global_origin_encode(487, 22, 0, t_us))
        if pick.random() < 0.02:
            messages.append(mav.heartbeat_encode(11, 3, 128, 6, 4))
        return b"".join(message.pack(mav) for message in messages)

    def command(self, number: int, values: tuple[float, ...]) -> bytes:
        """A COMMAND_LONG."""
        mav = self.senders[OPERATOR, 190]
        padded = (*values, *[0.0] * (7 - len(values)))
        return bytes(mav.command_long_encode(OWN, 1, number, 0, *padded).pack(mav))

    def operator(self) -> bytes:
        """A random request, command or stick message."""
        pick, mav = self.random, self.senders[OPERATOR, 190]
        kind = pick.randrange(5)
        if kind == 0:
            message = mav.heartbeat_encode(6, 8, 0, 0, 4)
        elif kind == 1:
            message = mav.manual_control_encode(OWN, pick.randrange(1000), 0, 500, 0, 0)
        elif kind == 2:
            name = pick.choice(list(self.boat.parameters())).encode()
            message = mav.param_set_encode(OWN, 1, name, pick.uniform(0.0, 5.0), 9)
        elif kind == 3:
            message = mav.param_request_list_encode(OWN, 1)
        else:
            return self.command(*pick.choice(COMMANDS))
        return bytes(message.pack(mav))

    def digest(self, ticks: int) -> str:
        """The digest of all output of the boat in that many ticks."""
        pick, out = self.random, hashlib.sha256()
        calm = pick.random() < 0.7  # states come regularly
        silent_us = pick.choice([ticks * TICK_US, pick.randrange(ticks * TICK_US)])  # an ESC's end
        for k in range(1, ticks + 1):
            t_us = k * TICK_US
            for who in self.senders:
                if who[0] != OPERATOR and pick.random() < (0.5 if calm and who[0] != 7 else 0.02):
                    self.boat.on_mavlink(self.state(who, t_us), t_us, link=pick.randrange(2))
            if calm and k in (300, 320):
                self.boat.on_mavlink(self.command(*COMMANDS[0 if k == 300 else 4]), t_us, link=0)
            if pick.random() < (0.01 if calm else 0.05):
                self.boat.on_mavlink(self.operator(), t_us, link=0)
            if pick.random() < 0.01:
                self.boat.on_mavlink(pick.randbytes(pick.randrange(60)), t_us, link=1)
            for esc in self.escs[: 2 if t_us < silent_us else 1]:
                for can_id, data in esc.tick(t_us, 0.0, 24.0, 1.0):
                    self.boat.on_can(can_id, data, t_us)
            said = self.boat.tick(t_us)
            for can_id, data in said.can:
                for esc in self.escs:
                    esc.on_can(can_id, data, t_us)
            out.update(repr((said.mavlink, said.can, self.boat.state)).encode())
        return out.hexdigest()


def main() -> None:
    """Print a line for each run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0, help="of each scenario (20)")
    parser.add_argument("--ticks", type=int, default=1000, help="of each history (1000)")
    options = parser.parse_args()
    for line in of_scenarios(options.seconds):
        print(line)
    for seed in track(range(HISTORIES), console=Console(stderr=True)):
        print(f"history {seed}: {History(seed).digest(options.ticks)}")


if __name__ == "__main__":
    main()
