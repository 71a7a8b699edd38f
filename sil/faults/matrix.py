# SPDX-License-Identifier: MIT
"""Sails the rows of the matrix of faults in lockstep and judges each by its limits."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sil.faults.fault_outcome import Outcome
from sil.faults.rows import Row
from sil.faults.watch import CENTRED_S, OFF, STATES, States, Watch
from sil.lockstep import metrics
from sil.lockstep.start import RunError
from sil.lockstep.world import Progress, Run, sail
from sil.plant.hull import Array

_NAMES = {number: name for name, number in STATES.items()}
_STEP_N = 0.01  # RawCommand quantises thrust to a few mN


def sail_all(rows: Sequence[Row], progress: Progress = lambda _: None) -> list[Outcome]:
    """Sail the rows together; ValueError or ScenarioError if one of them is invalid."""
    scenarios = [row.scenario() for row in rows]
    longest = max(round(one.duration_s * one.rate_hz) + 1 for one in scenarios)
    watch = Watch(rows, longest)
    runs = sail(scenarios, {}, watch=watch, progress=progress)
    outcomes = []
    for i, (row, one, run) in enumerate(zip(rows, scenarios, runs, strict=True)):
        if isinstance(run, RunError):
            outcomes.append(Outcome(row.name, None, "not sailed", 0.0, None, False, str(run)))
            continue
        ticks = len(run.trace["t_s"])
        pair = one.propeller_pairs()[row.boat - 1]
        command = watch.commands[i, :ticks]
        most_N = np.where(command > 0.0, pair.forward_max_N, pair.reverse_max_N)
        level_N = np.abs(command) * most_N
        begins_s = row.begins_s if row.fence_m is None else _left_s(row, run)
        error_m = metrics.distances(run.trace["error"][:, row.boat - 1])
        told = _Seen(row, 1.0 / one.rate_hz, watch.states[i, :ticks], level_N, error_m)
        outcome = _heard(row, watch.texts[i], told.judge(begins_s))
        outcomes.append(_kept(row, run.trace["eta"][:, row.boat], 1.0 / one.rate_hz, outcome))
    return outcomes


def _heard(row: Row, texts: Sequence[str], outcome: Outcome) -> Outcome:
    """The outcome, changed to failed if the boat did not send the row's words."""
    if row.told is None or any(row.told in text for text in texts):
        return outcome
    return _failed(outcome, f'"{row.told}" was not told, but {sorted(set(texts))}')


def _kept(row: Row, eta: Array, h_s: float, outcome: Outcome) -> Outcome:
    """The outcome, changed to failed if the boat came too near to the row's place."""
    if row.keeps_m is None:
        return outcome
    begin = round(max(fault.at_s for fault in row.fault) / h_s)
    ahead_m, least_m = row.keeps_m
    north, east, psi = eta[begin]
    there = np.array([north + ahead_m * np.cos(psi), east + ahead_m * np.sin(psi)])
    nearest_m = float(np.hypot(*(eta[begin:, :2] - there).T).min())
    near = f"{nearest_m:.2f} m from the other vessel, not {least_m:g} m"
    return outcome if nearest_m >= least_m else _failed(outcome, near)


def _failed(outcome: Outcome, why: str) -> Outcome:
    return replace(outcome, passed=False, why="; ".join(filter(None, (outcome.why, why))))


def _left_s(row: Row, run: Run) -> float:
    """Time at which the boat leaves its fence, a circle around its start."""
    eta = run.trace["eta"][:, row.boat, :2]
    away_m = np.hypot(*(eta - eta[0]).T)
    return float(run.trace["t_s"][np.argmax(away_m > (row.fence_m or 0.0))])


class _Seen:
    """One boat's run by ticks: states, commanded thrusts, distance from its slot."""

    def __init__(self, row: Row, h_s: float, states: States, thrust_N: Array, error_m: Array):
        self._row, self._h_s, self._states, self._error_m = row, h_s, states, error_m
        kept = [i for i, esc in enumerate(("port", "stbd")) if row.but != esc]
        self._thrust_N = thrust_N[:, kept].max(axis=1)
        self._why: list[str] = []

    def judge(self, begins_s: float) -> Outcome:
        """The outcome of the fault that begins at `begins_s`, judged by the row's limits."""
        row = self._row
        self._begin = round(begins_s / self._h_s)
        self._end = max(self._begin, round(row.ends_s / self._h_s))
        left = np.flatnonzero(self._states[self._begin :] != STATES["FORMATION"])
        self._left = self._begin + int(left[0]) if len(left) else None
        if (self._states[: self._begin] != STATES["FORMATION"]).any():
            self._why.append("left FORMATION before anything went wrong")
        detected_s = None
        if self._left is not None:
            detected_s = round((self._left - self._begin) * self._h_s, 6)
        self._check_state(detected_s)
        thrust_N = self._thrust_after()
        recovered_s = self._recovered()
        self._check_return()
        self._check_way_home()
        self._check_error()
        why = "; ".join(self._why)
        return Outcome(row.name, detected_s, self._went(), thrust_N, recovered_s, not why, why)

    def _check_state(self, detected_s: float | None) -> None:
        row = self._row
        wanted = " or ".join(row.states)
        if self._left is None:
            if "FORMATION" not in row.states:
                self._why.append(f"not detected; expected {wanted}")
            return
        state = _NAMES[int(self._states[self._left])]
        if state not in row.states:
            self._why.append(f"{state}, not {wanted}")
        assert detected_s is not None
        if row.detected_s is not None and detected_s > row.detected_s + 1e-9:
            self._why.append(f"detected after {detected_s:.2f} s, not {row.detected_s:g} s")
        if row.lasts_s is not None and self._lasted_s() < row.lasts_s - 1e-9:
            self._why.append(f"{state} for {self._lasted_s():.2f} s only")
        if row.then is not None:
            self._check_next(state, row.then, row.then_s)

    def _lasted_s(self) -> float:
        assert self._left is not None
        after = self._states[self._left :]
        return float(np.argmax(np.append(after != after[0], True)) * self._h_s)

    def _check_next(self, state: str, then: str, then_s: float) -> None:
        after = self._states[self._left :]
        others = np.flatnonzero(after != STATES[state])
        if not len(others):
            self._why.append(f"{state} to the end")
            return
        lasted_s, ended_in = int(others[0]) * self._h_s, _NAMES[int(after[others[0]])]
        if ended_in != then or lasted_s > then_s + 1e-9:
            self._why.append(f"{state} for {lasted_s:.2f} s, then {ended_in}")

    def _check_return(self) -> None:
        """A boat that needs the operator must not return to FORMATION before."""
        begun = np.flatnonzero(np.isin(self._states[self._begin : self._end], OFF))
        if self._row.recovery != "operator" or not len(begun):
            return
        waiting = self._states[self._begin + int(begun[0]) : self._end]
        if (waiting == STATES["FORMATION"]).any():
            self._why.append("back in FORMATION before the operator's command")

    def _check_way_home(self) -> None:
        """The sticks must drive the boat at the end, but not before they were at neutral."""
        if self._row.home_s is None:
            return
        manual = self._states == STATES["MANUAL"]
        if not (manual[-1] and self._thrust_N[-1] > 0.0):
            self._why.append(f"not driven home: {_NAMES[int(self._states[-1])]} in the end")
        centred = self._begin + round((self._row.home_s + CENTRED_S) / self._h_s)
        at_neutral = manual[centred : centred + 1].any()
        if not at_neutral or (self._thrust_N[:centred][manual[:centred]] > 0.0).any():
            self._why.append("MANUAL pushed before the sticks were at neutral, or began too late")

    def _check_error(self) -> None:
        row = self._row
        alone = self._states == STATES["FORMATION"]
        if row.recovery == "operator" and self._left is not None:
            alone[self._left :] = False
        farthest_m = self._error_m[alone].max()
        if row.error_m is not None and farthest_m > row.error_m:
            self._why.append(f"{farthest_m:.2f} m from its slot, not {row.error_m:g} m")

    def _thrust_after(self) -> float:
        """The greatest thrust where there should be none; without such ticks, that in COAST."""
        if self._left is None:
            return 0.0
        begin, late = self._left, round(self._row.off_s / self._h_s)
        off = np.isin(self._states, OFF)
        off[:begin] = False
        still = off.copy()
        for lag in range(1, late + 1):
            still[lag:] &= off[:-lag]
        thrust_N = float(self._thrust_N[still].max(initial=0.0))
        if thrust_N > 0.0:
            self._why.append(f"{thrust_N:.2f} N commanded where none is allowed")
        coast = self._states == STATES["COAST"]
        rise_N = float(np.diff(self._thrust_N)[coast[1:]].max(initial=0.0))
        if rise_N > _STEP_N:
            self._why.append(f"thrust rose by {rise_N:.2f} N in COAST")
        if off.any():
            return thrust_N
        return float(self._thrust_N[coast].max(initial=0.0))

    def _recovered(self) -> float | None:
        row = self._row
        away = np.flatnonzero(self._states != STATES["FORMATION"])
        last = int(away[-1]) + 1 if len(away) else 0
        back = self._left is not None and last < len(self._states)
        recovered_s = max(0.0, round((last - self._end) * self._h_s, 6)) if back else None
        if row.recovery is None or self._left is None:
            return recovered_s
        if recovered_s is None:
            self._why.append("not back in FORMATION")
        elif row.recovered_s is not None and recovered_s > row.recovered_s + 1e-9:
            self._why.append(f"back after {recovered_s:.2f} s, not {row.recovered_s:g} s")
        return recovered_s

    def _went(self) -> str:
        """The states it went through until the fault ended and until it had recovered."""
        if self._left is None:
            return "FORMATION"
        after = self._states[self._left :]
        changes = [0, *(np.flatnonzero(np.diff(after.astype(int))) + 1).tolist()]
        names = [_NAMES[int(after[i])] for i in changes]
        shown = names[: names.index("FORMATION")] if "FORMATION" in names else names
        return ", ".join(shown[:3])
