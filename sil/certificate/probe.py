# SPDX-License-Identifier: MIT
"""Sails chains of boats to measure how small motions pass from boat to boat.

The boats are whole firmwares in `flotilla.Fleet`: bytes, radio with its delay and loss, SR_STATE,
clocks, predictor, reference, law, THR_SLEW. All go straight ahead at the leader's speed. One agent,
the root or boat 2, is pushed by many small sinusoids in surge and in yaw at once, with random
phases. All sinusoids have whole periods in the window of observation, so that the Fourier
components of the agents' motions at these frequencies are the gains, regardless of other effects of
sampling. Noise, wind, waves and mismatch are off in these runs. Two more kinds of runs measure the
motion to be amplified: one behind the leader's own manoeuvre, also without noise, and some with all
of the scenario's noise and weather behind a leader that goes straight.

Where boats hear their neighbours only, and the radio loses messages, some more runs have everything
at once: the manoeuvre, noise, weather, and different losses in each run. A reference that comes
over many hops is sometimes too old to be passed on. That is rare, makes boats jump, and adds to
neither gains nor noise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
import numpy.typing as npt

from sil.certificate.references import Reference
from sil.lockstep.batch import Batch
from sil.lockstep.start import RunError
from sil.lockstep.world import sail
from sil.plant.hull import Array
from sil.scenario.scenario import Boat, Scenario
from sil.scenario.sections import (
    Input,
    Leader,
    Mismatch,
    Navigation,
    Unit,
    Vessel,
    Water,
    Waves,
    WhiteNoise,
    Wind,
)

WINDOW_S, SETTLING_S = 120.0, 60.0
RUNS = 2  # number of runs of each kind
LOSSY_RUNS = 4
# whole periods in the window: yaw has every second one, surge those between
_PERIODS = np.unique(np.geomspace(2.0, 300.0, 44).round().astype(int))
YAW, SURGE = 2, 0  # components of nu
_SMALL = 0.004  # amplitude of each sinusoid, rad/s, m/s; below 1 rad/s in proportion
PUSHED_BOAT, _RESISTED = 2, 6.0
_KEEP_S = 0.05
_SEED = 20
_DRIVEN = {"FORMATION", "COAST"}


def frequencies(axis: int) -> Array:
    """Angular frequencies, rad/s, at which an axis is excited."""
    return 2.0 * pi / WINDOW_S * _PERIODS[0 if axis == YAW else 1 :: 2]


Motions = tuple[Array, Array]
Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Probe:
    """Motions of a chain's runs in the window: velocities (T, agents, 3) and errors (T, boats, 3).

    `root` and `boat`: RUNS runs each, in which the root or the boat is pushed; `manoeuvre`: one
    run; `noisy`: RUNS runs; `lossy`: LOSSY_RUNS runs with everything, if boats relay with losses.
    """

    t_s: Array
    root: Sequence[Motions]
    boat: Sequence[Motions]
    manoeuvre: Motions
    noisy: Sequence[Motions]
    lossy: Sequence[Motions] = ()


def gains(t_s: Array, runs: Sequence[Motions], axis: int, pushed: int) -> tuple[Complex, Complex]:
    """Gains of velocity (agents, M) and error (boats, M) by the velocity of agent `pushed`.

    The error is e_y for yaw and e_x for surge.
    """
    basis = np.exp(-1j * np.outer(frequencies(axis), t_s))
    agents = runs[0][0].shape[1]
    velocity = np.zeros((len(basis), agents), np.complex128)
    error = np.zeros((len(basis), agents - 1), np.complex128)
    power = np.zeros((len(basis), 1))
    for nu, e in runs:
        own = basis @ nu[:, :, axis]
        cause = own[:, pushed : pushed + 1]
        velocity += own * cause.conj()
        error += (basis @ e[:, :, 1 if axis == YAW else 0]) * cause.conj()
        power += np.abs(cause) ** 2
    return np.asarray(velocity / power).T, np.asarray(error / power, np.complex128).T


def probe(
    chain: Scenario, reference: Reference, overrides: dict[str, float], path: Sequence[int]
) -> Probe:
    """Sail a chain (`chain_of`) of a path; RunError if a boat cannot sail or leaves its slot."""
    straight = _behind(chain, Input(surge_N=reference.input.surge_N))
    calm = _calm(straight)
    manoeuvre = _behind(chain, reference.input.model_copy(update={"from_s": 0.0}))
    lossy = LOSSY_RUNS if chain.link.loss > 0.0 and not chain.link.everyone else 0
    scenarios = [
        *(_seeded(calm, run) for run in range(2 * RUNS)),
        _calm(manoeuvre),
        *(_seeded(straight, run) for run in range(RUNS)),
        *(_seeded(manoeuvre, run) for run in range(lossy)),
    ]
    motions = []
    for run in sail(scenarios, overrides, keep_s=_KEEP_S, watch=_Push(calm).step):
        if isinstance(run, RunError):
            raise run
        inside = run.trace["t_s"] >= SETTLING_S + 0.5 * _KEEP_S
        t_s = run.trace["t_s"][inside]
        nu, error = run.trace["nu"][inside], run.trace["error"][inside]
        if not (np.isfinite(nu).all() and np.isfinite(error).all()):
            raise RunError("the boats diverge on a straight course")
        stay(run.states, path)
        motions.append((nu, error))
    behind, last = 2 * RUNS, 3 * RUNS + 1
    return Probe(
        t_s,
        motions[:RUNS],
        motions[RUNS:behind],
        motions[behind],
        motions[behind + 1 : last],
        motions[last:],
    )


def stay(states: Sequence[Mapping[str, float]], path: Sequence[int]) -> None:
    """RunError if a boat was in a state other than FORMATION, or COAST, in which the law drives."""
    for k, seconds in enumerate(states):
        for state in seconds.keys() - _DRIVEN:
            boat = path[min(k, len(path) - 1)]
            raise RunError(f"boat {boat}, at depth {k + 1}, leaves FORMATION: {state}")


def path_to(scenario: Scenario, agent: int) -> list[int]:
    """Boats from the root's first follower down to a boat."""
    path: list[int] = []
    while agent > 0:
        path.insert(0, agent)
        agent = scenario.boat[agent - 1].follows
    return path


def deepest(scenario: Scenario) -> list[int]:
    """The longest path from the root to a boat; if there are several, the first."""
    paths = (path_to(scenario, agent) for agent in range(1, len(scenario.boat) + 1))
    return max(paths, key=len)


def chain_of(
    scenario: Scenario, path: Sequence[int], depth: int, *, scale: tuple[float, float] = (1.0, 1.0)
) -> Scenario:
    """`depth` boats in a line: those of a path, then as many copies of its last as needed.

    `scale`: factors of the hulls' masses and dampings. Boats start on their slots, at rest.
    """
    masses, dampings = scale
    agents = [path[min(k, len(path) - 1)] for k in range(depth)]
    vessels = scenario.vessels()
    place, boats = np.zeros(2), []
    for k, agent in enumerate(agents):
        own = scenario.boat[agent - 1]
        # a copied boat is not on the slot that the original has behind the root
        first_again = k > 0 and agent == path[0]
        offset_m = scenario.boat[path[1] - 1].offset_m if first_again else own.offset_m
        place = place + offset_m
        hull = vessels[agent]
        changed = {f"m{axis}": masses * getattr(hull, f"m{axis}") for axis in ("11", "22", "33")}
        changed |= {
            name: dampings * getattr(hull, name)
            for name in (
                *("d11", "d22", "d33", "d11_quadratic", "d33_quadratic", "d33_speed"),
                "crossflow_cd",
            )
        } | {"m23": masses * hull.m23}
        vessel = Vessel(**{**hull.model_dump(), **changed})
        update = {
            "follows": k,
            "offset_m": offset_m,
            "eta": (*place.tolist(), 0.0),
            "nu": (0.0, 0.0, 0.0),
        }
        boats.append(Boat(**{**own.model_dump(exclude_unset=True), **update, "vessel": vessel}))
    return scenario.model_copy(
        update={
            "boat": tuple(boats),
            "fault": (),
            "vary": (),
            "mismatch": Mismatch(),
            "duration_s": SETTLING_S + WINDOW_S,
        }
    )


def _behind(chain: Scenario, only: Input) -> Scenario:
    unit: Unit = chain.leader.navigation
    leader = Leader(navigation=unit, input=(only,))
    return chain.model_copy(update={"leader": leader})


def _calm(chain: Scenario) -> Scenario:
    silent = {name: 0.0 for name in Navigation.model_fields if "_noise_" in name}
    silent["position_drift_m"] = 0.0
    update = {
        "navigation": chain.navigation.model_copy(update=silent),
        "wind": Wind(),
        "waves": Waves(),
        "white_noise": WhiteNoise(),
        "water": Water(),
    }
    return chain.model_copy(update=update)


def _seeded(chain: Scenario, run: int) -> Scenario:
    return chain.model_copy(update={"seed": chain.seed + run})


class _Push:
    """The forces that push agents of the first 2 RUNS runs."""

    def __init__(self, chain: Scenario) -> None:
        root = chain.hulls()[0]
        rng = np.random.default_rng(_SEED)
        h_s = 1e-6 * round(1e6 / chain.rate_hz)
        t_s = h_s * np.arange(round((SETTLING_S + WINDOW_S) / h_s) + 1)
        # by tick, run and component of nu
        self._forces = np.zeros((t_s.size, 2 * RUNS, 3))
        for axis, mass, damping in ((YAW, root.m33, root.d33), (SURGE, root.m11, root.d11)):
            omega = frequencies(axis)
            size = _SMALL * np.minimum(omega, 1.0) * np.hypot(damping, mass * omega)
            phase = rng.uniform(0.0, 2.0 * pi, (2 * RUNS, omega.size))
            for run in range(2 * RUNS):
                waves = size * np.sin(t_s[:, None] * omega + phase[run])
                # a boat's own law resists the push
                share = 1.0 if run < RUNS else _RESISTED
                self._forces[:, run, axis] = share * waves.sum(axis=1)

    def step(self, batch: Batch, members: Sequence[int], k: int, _t_us: int) -> None:
        """Set the forces of tick k."""
        push = np.zeros_like(batch.bodies.nu)
        for run, member in enumerate(members):
            if member < 2 * RUNS:
                agent = 0 if member < RUNS else PUSHED_BOAT
                push[batch.row(run, agent)] = self._forces[k, member]
        batch.bodies.push = push
