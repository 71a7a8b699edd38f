# SPDX-License-Identifier: MIT
"""A fleet that loses its leader, an inner boat, both, or half of its radio, while it sails a plan.

    python -m tests.loop.succession [--instants 8] [--kinds leader inner two restart split …]

The scenario `lead` with eight boats in a vee, on a radio that loses 30 % and is up to 0.3 s late.
All get the plan, one gets the fleet's table, and the radio does the rest. Then boat 1 is killed, or
boat 2, on which boats 4, 6 and 8 depend, or both; or boat 1 restarts, disarmed, within a second; or
the radio is split between boats 1 to 4 and 5 to 8 for 60 s. This happens at instants spread over
the plan. The true states and the boats' own reports are judged. On request: `inner3`, `inner4`:
boat 3 or 4 is killed; `paused`: an operator pauses boat 1, which is killed 5 s later; `left_out`: a
new table leaves out boat 8; `none`: nothing fails.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import flotilla
import numpy as np
from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console
from rich.progress import Progress

from sil.lockstep.batch import Batch
from sil.lockstep.trace import States
from sil.lockstep.world import all_sailed
from sil.lockstep.world import sail as sail_runs
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.formation import Place, slots
from sil.scenario.scenario import Scenario
from sil.scenario.sections import Fault
from sil.scenario.told_plan import items_of
from sil.wire.fleet_table import Beacon, Member, beacons, table_message
from sil.wire.operator import plan_upload
from sil.wire.plan_upload import PlanUpload

#: The boats that a failure kills.
KILLS = {"leader": (1,), "inner": (2,), "two": (1, 2), "restart": (1,)}
KINDS = (*KILLS, "split")
#: The boats that the fleet loses through a failure, or through a new table.
GONE = KILLS | {"inner3": (3,), "inner4": (4,), "paused": (1,), "left_out": (8,)}
NOTHING = "none"
#: A boat within this distance for that long is in its slot.
IN_SLOT_M, STAYS_S = 0.2, 5.0
#: A failure has had its effect after this time.
FELT_S = 10.0
FIRST_S, LAST_S, AFTER_S, SPLIT_S = 20.0, 80.0, 90.0, 60.0
FORMS_UP_S = 60.0
PAUSED_S, BACK_S = 5.0, 1.0
#: The leader of each boat in the table; 0: none.
TREE = (0, 1, 1, 2, 3, 2, 3, 4)
SETTINGS = (
    "leader.waypoints=[[0, 0], [70, 0], [70, 50], [0, 50]]",
    "formation.shape=vee",
    "formation.boats=8",
    "formation.spacing_m=5.0",
    "link.delay_s=0.15",
    "link.jitter_s=0.15",
    "link.loss=0.3",
    "link.everyone=true",
    "parameters.FS_COAST_S=15.0",
)
RADIO = 1
SIDE = range(4)  # boats from 0 on one side of a split

_AUTO = flotilla.STATES.index("AUTO")


@dataclass(frozen=True)
class Healed:
    """One run, times since the failure (or since the parts met again).

    `leads_s`: when one boat alone leads; `two_s`: how long two of those that hear each other did;
    `slots_s`: when all live boats are in their slots, for five seconds, 10 s after it at the
    earliest; `off_m`: greatest distance of one from its slot after 60 s; `nearest_m`: of two live
    boats; `wreck_m`: of a live boat from a dead one; `goes_on`: the leader sails the plan at the
    end; `states`: of the live boats at the end; `gone`: of the others.
    """

    kind: str
    at_s: float
    leads_s: float
    two_s: float
    slots_s: float
    off_m: float
    nearest_m: float
    wreck_m: float
    goes_on: bool
    states: tuple[str, ...]
    gone: tuple[str, ...]


class Track:
    """What one run showed, ten times a second: states, poses and claims to lead of all boats."""

    def __init__(self) -> None:
        self.t_s: list[float] = []
        self.states: list[States] = []
        self.eta: list[Array] = []
        self.leads: list[list[bool]] = []


class Observer:
    """Gives each run its plans and its table after the release, splits radios, and listens."""

    def __init__(self, kind: str, instants: Sequence[float], one: Scenario) -> None:
        self.kind, self.instants, self.one = kind, instants, one
        self.places = slots(one.formation) if one.formation else []
        self.members = [
            Member(i + 1, leader, place, one.vessel.length_m)
            for i, (leader, place) in enumerate(zip(TREE, self.places, strict=True))
        ]
        self.tracks = [Track() for _ in instants]
        self._said: dict[tuple[int, int], Beacon] = {}
        self._uploads: dict[tuple[int, int], PlanUpload] = {}

    def __call__(self, batch: Batch, members: Sequence[int], k: int, t_us: int) -> None:
        if k == 0:
            self._begin(batch, t_us)
        for run, member in enumerate(members):
            for boat, agent in enumerate(batch.agents(run)):
                self._exchange(batch, run, boat, agent, t_us)
            if self.kind == "split":
                self._split(batch, run, self.instants[member], k)
            else:
                self._order(batch, run, self.instants[member], k, t_us)
            if k % 10 == 0:
                self._note(batch, run, self.tracks[member], k)

    def _note(self, batch: Batch, run: int, track: Track, k: int) -> None:
        rows = list(batch.agents(run))
        track.t_s.append(k * self.one.step_s)
        track.states.append(batch.states[run].copy())
        track.eta.append(batch.bodies.eta[rows].copy())
        track.leads.append([self._leads(run, boat) for boat in range(batch.boats)])

    def _leads(self, run: int, boat: int) -> bool:
        said = self._said.get((run, boat + 1))
        return said is not None and said.leads

    def _begin(self, batch: Batch, t_us: int) -> None:
        self._said.clear()
        self._uploads.clear()
        for run in range(len(batch.scenarios)):
            second = batch.agents(run)[1]
            batch.fleet.hear(second, table_message(1, self.members, in_s=3.0), t_us, RADIO)
            for boat in range(1, batch.boats):
                upload = plan_upload(boat + 1, items_of(self.one.leader))
                self._uploads[run, boat] = upload

    def _exchange(self, batch: Batch, run: int, boat: int, agent: int, t_us: int) -> None:
        said = batch.fleet.sent(agent)
        for system, beacon in beacons(said):
            self._said[run, system] = beacon
        upload = self._uploads.get((run, boat))
        if upload is None or upload.done:
            return
        upload.on_mavlink(said, t_us)
        if words := upload.say(t_us):
            batch.fleet.hear(agent, words, t_us, RADIO)

    def _order(self, batch: Batch, run: int, at_s: float, k: int, t_us: int) -> None:
        first, second, *_ = batch.agents(run)
        if self.kind == "paused" and k == round((at_s - PAUSED_S) / self.one.step_s):
            batch.fleet.command([first], t_us, mavlink.MAV_CMD_DO_PAUSE_CONTINUE, (0.0,))
        if self.kind == "left_out" and k == round(at_s / self.one.step_s):
            table = table_message(2, self.members[:-1], in_s=1.0)
            batch.fleet.hear(second, table, t_us, RADIO)

    def _split(self, batch: Batch, run: int, at_s: float, k: int) -> None:
        begins, ends = (round(x / self.one.step_s) for x in (at_s, at_s + SPLIT_S))
        if k not in (begins, ends):
            return
        pairs = self.one.pairs()
        quality = dict(self.one.link.quality)
        if k == begins:
            quality["loss"] = 1.0
        for number, (a, b) in enumerate(pairs):
            if 0 in (a, b) or ((a - 1) in SIDE) == ((b - 1) in SIDE):
                continue
            for way in range(2):
                link = 2 * (run * len(pairs) + number) + way
                batch.fleet.set_link(link, **quality)


def apart_s(kind: str) -> float:
    """How long the parts of the fleet sail apart."""
    return SPLIT_S if kind == "split" else 0.0


def scenarios_of(kind: str, instants: Sequence[float]) -> list[Scenario]:
    """The runs of that kind of failure."""
    base = scenario.load("lead", SETTINGS)
    rest_s = AFTER_S + apart_s(kind)
    made = []
    for seed, at_s in enumerate(instants, start=1):
        killed = GONE.get(kind, ()) if kind != "left_out" else ()
        for_s = BACK_S if kind == "restart" else None
        update = {
            "seed": seed,
            "duration_s": max(instants) + rest_s,
            "fault": tuple(
                Fault(kind="restart", agent=boat, at_s=at_s, for_s=for_s) for boat in killed
            ),
        }
        made.append(base.model_copy(update=update))
    return made


def sail(kind: str, instants: Sequence[float]) -> list[Healed]:
    """Sail one run for each instant, together."""
    chosen = scenarios_of(kind, instants)
    observer = Observer(kind, instants, chosen[0])
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(kind, total=1.0)
        runs = sail_runs(
            chosen,
            {},
            keep_s=1.0,
            progress=lambda share: progress.update(task, completed=share),
            watch=observer,
        )
    all_sailed(runs)
    return [
        judge(track, observer.places, kind, at_s)
        for track, at_s in zip(observer.tracks, instants, strict=True)
    ]


def judge(track: Track, shape: Sequence[Place], kind: str, at_s: float) -> Healed:
    """Compare a run with what is asked of it."""
    t_s, states = np.array(track.t_s), np.array(track.states)
    eta, leads = np.array(track.eta), np.array(track.leads)
    dead = [boat - 1 for boat in GONE.get(kind, ())]
    live = [boat for boat in range(states.shape[1]) if boat not in dead]
    from_s = at_s + apart_s(kind)
    after = t_s >= from_s
    count = leads[after][:, live].sum(axis=1)
    step_s = float(t_s[1] - t_s[0])
    alone = np.flatnonzero(count == 1)
    leads_s = float(alone[0]) * step_s if len(alone) else np.inf
    leader = live[int(leads[-1][live].argmax())]
    places = np.array(shape)
    settled = t_s >= from_s + FORMS_UP_S
    off = eta[:, live, :2] - eta[:, leader, None, :2]
    off -= places[live] - places[leader]
    off_m = np.hypot(off[..., 0], off[..., 1]).max(axis=1)
    since = t_s >= at_s
    nearest = [
        np.hypot(*(eta[since][:, a, :2] - eta[since][:, b, :2]).T).min()
        for a in live
        for b in live
        if a < b
    ]
    wreck = [
        np.hypot(*(eta[since][:, a, :2] - eta[since][:, b, :2]).T).min() for a in live for b in dead
    ]
    return Healed(
        kind,
        at_s,
        leads_s,
        float((count > 1).sum()) * step_s,
        FELT_S + first_s(off_m[t_s >= from_s + FELT_S] <= IN_SLOT_M, step_s),
        float(off_m[settled].max()),
        float(min(nearest)),
        float(min(wreck, default=np.inf)),
        bool(states[-1, leader] == _AUTO),
        *(tuple(flotilla.STATES[state] for state in states[-1][each]) for each in (live, dead)),
    )


def first_s(holds: Array, step_s: float) -> float:
    """When this begins to be true for `STAYS_S`; infinite if it never does."""
    size = round(STAYS_S / step_s)
    whole = np.convolve(holds, np.ones(size), "valid") == size
    return float(np.flatnonzero(whole)[0]) * step_s if whole.any() else np.inf


def main() -> None:
    """Sail all kinds and print a line for each run."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--instants", type=int, default=8)
    parser.add_argument("--kinds", nargs="+", choices=(*GONE, "split", NOTHING), default=KINDS)
    given = parser.parse_args()
    names = ("failure", "at", "one leader after", "two for", "in slots after", "off its slot")
    print("|", " | ".join([*names, "nearest", "wreck", "plan"]), "|")
    for kind in given.kinds:
        instants = np.linspace(FIRST_S, LAST_S, given.instants).round(2).tolist()
        healed = sail(kind, instants)
        for it in healed:
            times = (it.at_s, it.leads_s, it.two_s, it.slots_s)
            places = (it.off_m, it.nearest_m, it.wreck_m)
            cells = [it.kind, *(f"{x:.1f}" for x in times), *(f"{x:.2f}" for x in places)]
            odd = set(it.states) - {"AUTO", "FORMATION"}
            print("|", " | ".join([*cells, "sailed" if it.goes_on else "ended", *odd]), "|")
        print(summary(kind, healed), flush=True)


def summary(kind: str, healed: Sequence[Healed]) -> str:
    """The worst of all runs of a kind, in words."""
    slots_s = np.array([it.slots_s for it in healed])
    late, off = slots_s > FORMS_UP_S, np.array([it.off_m for it in healed]) > IN_SLOT_M
    return (
        f"{kind}: {len(healed)} runs; one leader after {max(it.leads_s for it in healed):.1f} s at "
        f"most, two for {max(it.two_s for it in healed):.1f} s; nearest two "
        f"{min(it.nearest_m for it in healed):.2f} m; all in their slots after "
        f"{np.median(slots_s):.0f} s in the median, {late.sum()} times later than "
        f"{FORMS_UP_S:.0f} s; {off.sum()} times one was out of its slot after that; "
        f"{sum(not it.goes_on for it in healed)} plans ended"
    )


if __name__ == "__main__":
    main()
