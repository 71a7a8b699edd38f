# SPDX-License-Identifier: MIT
"""The boat in open loop against scipy's solution of the equations as they are printed."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from sil.identify.hull_terms import INDEX, TERMS
from sil.identify.voyage_model import Body, before, simulate, static_thrust
from tests.each_push import few

BODY = Body(arm_m=0.4, length_m=1.2, h_s=0.1)
SAMPLES = 100
# Current, wind and a moment; how the last two rise.
WEATHER = [0.1, 0.1, 3.0, 3.0, 0.01, 1.0, 1.0, 0.01]


def drawn(rng: np.random.Generator) -> dict[str, float]:
    """Terms of a boat within reason; the cross-flow is asked for by the one test that has it."""
    plain = {term.name: term.guess for term in TERMS}
    for name in ("m22", "m33", "d11", "d22", "d33", "d11_quadratic", "d33_speed", "forward"):
        plain[name] *= rng.uniform(0.6, 1.4)
    plain |= {
        "m23": rng.uniform(-0.05, 0.05),
        "gain": rng.uniform(-0.1, 0.1),
        "munk": 0.1,
        "wind_n": 0.003,
    }
    plain |= {"munk": 0.1, "wind_n": 0.003}
    return plain | {"dead": 0.05, "dead_time": 0.13, "advance": 0.05, "d22_quadratic": 0.0}


def column(terms: dict[str, float]) -> np.ndarray:
    out = np.empty((len(INDEX), 1))
    for name, k in INDEX.items():
        out[k] = terms[name]
    return out


def commands(rng: np.random.Generator) -> np.ndarray:
    """Levels that are held for 1.5 s."""
    levels = rng.uniform(-1.0, 1.0, (10, 1, 2))
    return np.repeat(levels, 15, axis=0)[: before(BODY.h_s) + SAMPLES]


def exact(
    p: dict[str, float], local: np.ndarray, start: np.ndarray, given: np.ndarray
) -> np.ndarray:
    """States (samples, 6): begin and end of each hold are never stepped over."""
    at_rest = static_thrust(column(p), given, BODY.gate)[:, 0, 0]
    inertia = np.array([[1, 0, 0], [0, p["m22"], p["m23"]], [0, p["m23"], p["m33"]]])
    half = 0.5 * BODY.length_m

    def strip(v: float, r: float, power: int) -> float:
        flow = quad(lambda x: x**power * abs(v + x * r) * (v + x * r), -half, half)[0]
        return float(p["d22_quadratic"] * flow / BODY.length_m)

    def rates(t: float, s: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        _, _, psi, u, v, r, port, stbd = s
        c = local[:2]
        wind_n, wind_e, turn = local[2:5] + (2.0 * t / (0.1 * SAMPLES) - 1.0) * local[5:]
        to_body = np.array([[np.cos(psi), np.sin(psi)], [-np.sin(psi), np.cos(psi)]])
        air = to_body @ [wind_n, wind_e] - [u, v]
        push = np.hypot(*air) * air
        moment = inertia @ [u, v, r]
        coriolis = np.array([-moment[1] * r, moment[0] * r, moment[1] * u - moment[0] * v])
        drag = np.array(
            [
                (p["d11"] + p["d11_quadratic"] * abs(u)) * u,
                (p["d22"] + p["d22_speed"] * abs(u)) * v + strip(v, r, 0),
                (p["d33"] + p["d33_quadratic"] * abs(r) + p["d33_speed"] * abs(u)) * r
                + p["munk"] * u * v
                + strip(v, r, 1),
            ]
        )
        lost = 1.0 - p["advance"] * u
        tau = np.array(
            [
                lost * (port + stbd) + p["wind_x"] * push[0],
                p["wind_y"] * push[1],
                BODY.arm_m * lost * (port - stbd) + turn - p["wind_n"] * air[0] * air[1],
            ]
        )
        nu_dot = np.linalg.solve(inertia, tau - coriolis - drag)
        eta_dot = [*(to_body.T @ [u, v] + c), r]
        return np.array([*eta_dot, *nu_dot, *((wanted - [port, stbd]) / p["lag"])])

    ahead = before(BODY.h_s)
    changes = np.arange(len(given)) * BODY.h_s + p["dead_time"] - ahead * BODY.h_s
    samples = np.arange(SAMPLES) * BODY.h_s
    s, t = np.array([*start, 0.0, 0.0]), float(changes[0])
    out: list[np.ndarray] = []
    for k, until in enumerate([*changes[1:], samples[-1] + 1.0]):
        for end in sorted({*samples[(samples > t - 1e-9) & (samples < until)], until}):
            if t < 0.0:  # only the thrust moves before the stretch begins
                s[6:] = at_rest[k] + (s[6:] - at_rest[k]) * np.exp(-(min(end, 0.0) - t) / p["lag"])
                t = min(end, 0.0)
            if end > t:
                s = solve_ivp(rates, (t, end), s, args=(at_rest[k],), rtol=1e-9, atol=1e-10).y[
                    :, -1
                ]
                t = float(end)
            if np.any(np.abs(samples - end) < 1e-9) and len(out) < SAMPLES and end >= 0.0:
                out.append(s[:6].copy())
    return np.array(out)


@pytest.mark.parametrize("seed", few(range(4), [0]))
def test_ten_seconds_agree_with_scipys_integrator(seed: int) -> None:
    rng = np.random.default_rng(seed)
    p, given = drawn(rng), commands(rng)
    local, start = rng.normal(0.0, WEATHER), rng.normal(0.0, 0.3, 6)
    places = local[:, None, None], start[:, None, None]
    simulated = simulate(column(p), *places, given, BODY)[:, :, 0, 0]
    true = exact(p, local, start, given)
    assert len(true) == SAMPLES
    ground = true.copy()
    cos, sin = np.cos(true[:, 2]), np.sin(true[:, 2])
    ground[:, 3] += cos * local[0] + sin * local[1]
    ground[:, 4] += cos * local[1] - sin * local[0]
    print(f"seed {seed}: {np.abs(simulated - ground).max(axis=0)}")
    assert np.abs(simulated - ground).max() < 0.01


def test_cross_flow_brakes_as_its_integral_does() -> None:
    rng = np.random.default_rng(7)
    p = drawn(rng) | {"d22_quadratic": 3.0}
    given, start = commands(rng), np.array([0.0, 0.0, 0.0, 0.5, 0.3, 0.4])
    still = np.zeros(8)
    simulated = simulate(column(p), still[:, None, None], start[:, None, None], given, BODY)
    error = np.abs(simulated[:, :, 0, 0] - exact(p, still, start, given))
    print(error.max(axis=0))
    assert error[:, 3:].max() < 0.02


def test_a_deviated_compass_turns_heading_and_velocity_alike() -> None:
    p = drawn(np.random.default_rng(3))
    given = np.zeros((before(BODY.h_s) + SAMPLES, 1, 2))
    start, still = np.array([0.0, 0.0, 0.5, 1.0, 0.2, 0.0])[:, None, None], np.zeros((8, 1, 1))
    true = simulate(column(p), still, start, given, BODY)[:, :, 0, 0]
    seen = simulate(column(p | {"compass": 0.1}), still, start, given, BODY)[:, :, 0, 0]
    assert np.allclose(seen[:, 2] - true[:, 2], 0.1)
    over_ground = [(m[:, 3] + 1j * m[:, 4]) * np.exp(1j * m[:, 2]) for m in (true, seen)]
    assert np.allclose(*over_ground)
