# SPDX-License-Identifier: MIT
"""Pairs the runs of two campaigns that have the same seed and the same draws."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from sil.campaign.finished import Campaign, columns

_MOST = 8
_SHAPE = ("duration_s", "rate_hz", "follows")


@dataclass(frozen=True)
class Pairing:
    """Two campaigns to be compared; if paired, only their common runs, in the same order.

    `about`: how they are compared, and why. `differences`: what differed between the campaigns.
    `same`: every pair of runs has the same digest.
    """

    a: Campaign
    b: Campaign
    paired: bool
    about: str
    differences: list[str]
    same: bool


def pair(a: Campaign, b: Campaign) -> Pairing:
    """Pair two campaigns of a scenario; ValueError if they cannot be compared."""
    if (a.scenario, a.boats) != (b.scenario, b.boats):
        told = (f"{c.folder} has {c.scenario}, boats: {c.boats}" for c in (a, b))
        raise ValueError(f"not one scenario: {'; '.join(told)}. Sail one scenario twice")
    for what, own, other in zip(_SHAPE, _shape(a), _shape(b), strict=True):
        if own != other:
            raise ValueError(f"not one {what}: {_short(own)}, in B {_short(other)}")
    differences = _told(a.header, b.header)
    if a.header["seed"] != b.header["seed"]:
        return Pairing(a, b, False, "unpaired: other seeds", differences, False)
    common = np.intersect1d(a.runs, b.runs)
    if common.size == 0:
        spans = (f"{c.folder} has runs {c.runs[0]} to {c.runs[-1]}" for c in (a, b))
        raise ValueError(f"no common runs: {', '.join(spans)}; sail both with the same --runs")
    own, other = _only(a, common), _only(b, common)
    if not _draw_alike(own, other):
        about = "unpaired: the same seed, but what it draws differs"
        return Pairing(a, b, False, about, differences, False)
    same = bool(np.array_equal(own.digest, other.digest))
    about = f"paired: {common.size} runs with the same seeds and draws"
    return Pairing(own, other, True, about, differences, same)


def _shape(campaign: Campaign) -> tuple[Any, Any, Any]:
    """Properties that runs must share to be compared: duration, rate, leaders; None if unknown."""
    document = campaign.header.get("document", {})
    follows = [boat.get("follows") for boat in document.get("boat", [])]
    return document.get("duration_s"), document.get("rate_hz"), follows


def _only(campaign: Campaign, runs: npt.NDArray[np.int64]) -> Campaign:
    row = np.isin(campaign.runs, runs)
    return replace(
        campaign,
        runs=campaign.runs[row],
        outcome=campaign.outcome[row],
        reason=campaign.reason[row],
        digest=campaign.digest[row],
        cells={name: values[row] for name, values in campaign.cells.items()},
    )


def _draw_alike(a: Campaign, b: Campaign) -> bool:
    if not np.array_equal(a.cells["seed"], b.cells["seed"]):
        return False
    return _draws(a) == _draws(b)


def _draws(campaign: Campaign) -> dict[tuple[int, str], tuple[str, ...]]:
    """The drawn values, by run and key."""
    table = columns(campaign.folder, "draws")
    run, key = table.pop("run"), table.pop("key")
    row = np.isin(run, campaign.runs)
    places = zip(run[row].tolist(), key[row].tolist(), strict=True)
    # as text, NaN is equal to itself
    values = zip(*(map(repr, column[row].tolist()) for column in table.values()), strict=True)
    return dict(zip(places, values, strict=True))


def _told(a: dict[str, Any], b: dict[str, Any]) -> list[str]:
    """The differences of the two campaigns, one line per key."""
    found = [
        line
        for name in ("document", "parameters", "code")
        for line in _differences("" if name == "document" else name, a.get(name), b.get(name))
    ]
    more = [f"and {len(found) - _MOST} more differences"] if len(found) > _MOST else []
    return found[:_MOST] + more


def _differences(key: str, a: Any, b: Any) -> Iterator[str]:
    if isinstance(a, list) and isinstance(b, list) and any(isinstance(x, dict) for x in a + b):
        a, b = ({str(i): x for i, x in enumerate(side, start=1)} for side in (a, b))
    if isinstance(a, dict) and isinstance(b, dict):
        for name in dict.fromkeys([*a, *b]):
            yield from _differences(f"{key}.{name}".lstrip("."), a.get(name), b.get(name))
    elif a != b:
        yield "other code" if key == "code" else f"{key}: {_short(a)}, in B {_short(b)}"


def _short(value: Any) -> str:
    return "not given" if value is None else json.dumps(value)
