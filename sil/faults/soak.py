# SPDX-License-Identifier: MIT
"""Hours of random faults, one after another, for four boats in lockstep, with an operator."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from sil.bench.bench_fleet import resident_now_kB
from sil.faults.rows import FOLDER
from sil.faults.watch import OFF, RETRY_S, STATES, ask
from sil.lockstep.batch import Batch
from sil.lockstep.policies import violations
from sil.lockstep.recording import Recorder
from sil.lockstep.start import start
from sil.lockstep.timeline import act
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.fault_kinds import KINDS
from sil.scenario.sections import Fault

RECOVERED_S = 60.0
_QUIET_S = (2.0, 6.0)
_WELL_S = 3.0
_WARM, _MOST_MB = 3, 5.0  # hours until memory is steady; greatest growth after that
_OFF_S = 0.27  # an ESC stops within this time without a command

_KINDS = [kind for kind in KINDS.values() if kind.drawn is not None]


@dataclass
class Soaked:
    """The result: faults and `slowest_s` recovery by kind, failures, MB at each hour, digest."""

    faults: Counter[str] = field(default_factory=Counter)
    slowest_s: dict[str, float] = field(default_factory=dict)
    wrong: list[str] = field(default_factory=list)
    resident_MB: list[float] = field(default_factory=list)
    digest: str = ""


def soak(hours: float, seed: int, progress: Callable[[float, Soaked], None]) -> Soaked:
    """Sail for `hours`; calls `progress` with the share done every simulated minute.

    Failures, which end the soak: not all boats back in FORMATION within RECOVERED_S of a fault's
    end; thrust commanded in DISARMED, HOLD or FAULT to an ESC that obeys; a broken rule of the
    firmware; memory that grows after the first hours.
    """
    source = scenario.read(FOLDER / "soak.toml", [f"seed={seed}"])
    one = scenario.check(source)
    batch = Batch([one], {}, record=True)
    with Recorder(None, batch.header(0)) as recorder:
        batch.recorders = [recorder]
        (ready_us,) = start(batch)
        if not isinstance(ready_us, int):
            raise ready_us
        soaked = Soaked()
        _Sea(batch, np.random.default_rng(seed), soaked).sail(ready_us, hours, progress)
        batch.take()
        soaked.digest = recorder.finish()
    return soaked


class _Sea:
    """The boats, and the one fault that is active or being recovered from."""

    def __init__(self, batch: Batch, rng: np.random.Generator, soaked: Soaked) -> None:
        self._batch, self._rng, self._soaked = batch, rng, soaked
        self._h_s = 1e-6 * batch.h_us
        self._tau: Array = batch.scenarios[0].leader.tau(np.zeros(3))[:, None, :]
        self._fault: Fault | None = None
        self._next = self._in(rng.uniform(*_QUIET_S))  # tick of the next event
        self._ended: int | None = None
        self._well = 0  # tick since which all have been in FORMATION
        self._off = np.zeros(batch.boats, int)  # consecutive ticks in which thrust is forbidden

    def _in(self, time_s: float) -> int:
        return max(1, round(time_s / self._h_s))

    def sail(self, ready_us: int, hours: float, progress: Callable[[float, Soaked], None]) -> None:
        ticks, second = self._in(3600.0 * hours), self._in(1.0)
        minute, hour = 60 * second, 3600 * second
        for k in range(1, ticks + 1):
            t_us = ready_us + k * self._batch.h_us
            self._script(k, t_us)
            self._batch.tick(t_us)
            self._check(k)
            self._batch.bodies.advance(self._batch.command, self._tau, self._h_s)
            if k % hour == 0 or k == minute:
                self._note_memory()
            if k % second == 0:
                self._soaked.wrong += map(str, violations(self._batch).values())
            if k % minute == 0:
                progress(k / ticks, self._soaked)
            if self._soaked.wrong:
                return

    def _note_memory(self) -> None:
        sizes = self._soaked.resident_MB
        sizes.append(1e-3 * resident_now_kB())
        if sizes[-1] - sizes[: _WARM + 1][-1] > _MOST_MB:
            self._soaked.wrong.append(f"memory grows: {sizes[-1]:.1f} MB after {len(sizes) - 1} h")

    def _script(self, k: int, t_us: int) -> None:
        if self._ended is not None:
            self._recover(k, t_us)
        elif k >= self._next and self._fault is None:
            self._fault = self._drawn()
            self._soaked.faults[self._fault.kind] += 1
            seed = int(self._rng.integers(1 << 63))
            act(self._batch, 0, self._fault, True, t_us, seed)
            self._next = k + self._in(self._fault.for_s or 1.0)
        elif k >= self._next and self._fault is not None:
            act(self._batch, 0, self._fault, False, t_us)
            self._ended = self._well = k

    def _recover(self, k: int, t_us: int) -> None:
        assert self._fault is not None
        assert self._ended is not None
        states = self._batch.states[0].tolist()
        late_s = (k - self._ended) * self._h_s
        if any(state != STATES["FORMATION"] for state in states):
            self._well = k + 1
        if (k - self._well) * self._h_s >= _WELL_S:
            kind, slowest_s = self._fault.kind, self._soaked.slowest_s
            slowest_s[kind] = max((self._well - self._ended) * self._h_s, slowest_s.get(kind, 0.0))
            self._fault = self._ended = None
            self._next = k + self._in(self._rng.uniform(*_QUIET_S))
        elif late_s > RECOVERED_S:
            self._soaked.wrong.append(f"{self._fault!r}: not recovered by tick {k}: {states}")
        elif (k - self._ended) % self._in(RETRY_S) == 0:
            ask(self._batch, self._batch.agents(0), states, t_us)

    def _drawn(self) -> Fault:
        rng = self._rng
        kind = _KINDS[int(rng.integers(len(_KINDS)))]
        assert kind.drawn is not None
        negative = kind.least < 0.0 and rng.random() < 0.5
        value = float(rng.uniform(*kind.drawn)) * (-1.0 if negative else 1.0)
        for_s = float(rng.uniform(0.2, 8.0))
        esc = ("port", "stbd", "both")[int(rng.integers(3))]
        found = {
            "kind": kind.name,
            "agent": int(rng.integers(0 if kind.leaders else 1, self._batch.boats + 1)),
            "at_s": 0.0,
            "for_s": for_s + (value if kind.name == "replay" else 0.0),
            "value": value,
            "esc": esc if kind.owner == "ESCs" else "both",
        }
        return Fault.model_validate(found)

    def _check(self, k: int) -> None:
        off = np.isin(self._batch.states[0], OFF)
        self._off = np.where(off, self._off + 1, 0)
        told = np.abs(self._batch.command)
        fault = self._fault
        if fault is not None and fault.kind == "esc_stuck":
            told[fault.agent - 1, {"port": [0], "stbd": [1], "both": [0, 1]}[fault.esc]] = 0.0
        if (told.max(axis=1)[self._off > self._in(_OFF_S)] > 0.0).any():
            self._soaked.wrong.append(f"{fault!r}: forbidden thrust at tick {k}")
