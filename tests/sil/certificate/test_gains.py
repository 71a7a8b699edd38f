# SPDX-License-Identifier: MIT
"""The search for gains, on loops with made-up decay, and within its time."""

import math

import numpy as np
import pytest

from sil.certificate import monodromy, search
from sil.certificate.gains import CURVE_K_X, curve, fastest
from sil.certificate.loop import Boat
from sil.certificate.monodromy import Points
from tests.sil.certificate.made_up import SINE, boat


def somewhere(setup: Boat) -> tuple[Boat, Points]:
    """A boat at one instant."""
    return setup, monodromy.on_slot(setup, monodromy.instants(setup, 1, windows=1))


def hill(patch: pytest.MonkeyPatch, top: dict[str, float]) -> None:
    """Make the decay a hill over the logarithms of the gains, with one top."""

    def decay(setup: Boat, points: Points) -> tuple[float, float]:
        away = sum(math.log(setup.parameters[name] / x) ** 2 for name, x in top.items())
        return 0.05, 0.3 - 0.01 * away

    patch.setattr(search, "quick_decay", decay)


def test_search_finds_the_top_of_a_hill(monkeypatch: pytest.MonkeyPatch) -> None:
    top = {"LAW_KX": 0.31, "LAW_KPSI": 0.7}
    hill(monkeypatch, top)
    shares: list[float] = []
    found = fastest([somewhere(boat())], shares.append)
    assert found.complete and set(found.gains) == set(top)
    for name, gain in top.items():
        assert math.log(found.gains[name] / gain) == pytest.approx(0.0, abs=0.1)
    assert found.decay == 0.05 and found.decay_of_law == pytest.approx(0.3, abs=1e-3)
    assert shares == sorted(shares) and shares[-1] == 1.0 and shares[0] > 0.0


def test_look_ahead_is_searched_where_the_law_has_one(monkeypatch: pytest.MonkeyPatch) -> None:
    top = {"LAW_KX": 0.31, "LAW_KPSI": 0.7, "LAW_XT_DIST": 1.9}
    hill(monkeypatch, top)
    found = fastest([somewhere(boat(law="product"))], lambda _: None)
    assert found.gains["LAW_XT_DIST"] == pytest.approx(1.9, rel=0.15)


def test_fast_law_with_which_the_estimates_grow_is_not_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def decay(setup: Boat, points: Points) -> tuple[float, float]:
        k_x = setup.parameters["LAW_KX"]
        return (-0.1, -0.1) if k_x > 0.5 else (0.05, k_x)

    monkeypatch.setattr(search, "quick_decay", decay)
    found = fastest([somewhere(boat())], lambda _: None)
    assert 0.3 < found.gains["LAW_KX"] <= 0.5


def test_search_ends_when_its_count_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    for cycles in (0, 7):
        monkeypatch.setattr(search, "SEARCH_CYCLES", cycles)
        found = fastest([somewhere(boat(SINE))], lambda _: None)
        assert not found.complete and found.evaluations == cycles


def test_search_of_costly_loops_is_completed_on_a_coarser_grid(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(search, "SEARCH_CYCLES", 50)
    found = fastest([somewhere(boat(SINE))], lambda _: None)
    assert found.complete and 25 < found.evaluations <= 50


def test_gain_at_the_end_of_its_range_and_todays_decay_are_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hill(monkeypatch, {"LAW_KX": 50.0, "LAW_KPSI": 0.7})
    found = fastest([somewhere(boat())], lambda _: None)
    assert found.at_end == ["LAW_KX"] and found.gains["LAW_KX"] == pytest.approx(2.0)
    own = boat().parameters
    away = math.log(own["LAW_KX"] / 50.0) ** 2 + math.log(own["LAW_KPSI"] / 0.7) ** 2
    assert found.decay_of_law_now == pytest.approx(0.3 - 0.01 * away) and found.decay_now == 0.05


def test_decay_of_the_papers_law_peaks_at_the_gain_of_its_periodic_system() -> None:
    setup = boat()
    points = monodromy.on_slot(setup, monodromy.instants(setup, 24, windows=1))
    decays = [whole for whole, _ in curve(setup, points, lambda _: None)]
    assert CURVE_K_X[int(np.argmax(decays))] == pytest.approx(0.38, abs=0.06)
    assert max(decays) == pytest.approx(0.121, abs=0.002)
