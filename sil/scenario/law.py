# SPDX-License-Identifier: MIT
"""The laws that can control a scenario's boats, as sets of LAW_* parameters."""

from collections.abc import Mapping
from typing import Any, Literal, get_args

Law = Literal["product", "paper"]
LAWS: tuple[Law, ...] = get_args(Law)

# Wang and Loría, section III, and 0 for each of the product's extensions.
_PAPER = {
    "LAW_KX": 0.2,
    "LAW_KPSI": 0.2,
    "LAW_KDU": 10.0,
    "LAW_KDR": 10.0,
    "LAW_OBS_BW": 0.0,
    "LAW_XT_DIST": 0.0,
    "LAW_CUR_BW": 0.0,
    "LAW_U_MAX": 0.0,
    "LAW_R_MAX": 0.0,
    "LAW_REF": 0.0,
    "FS_SLOT_M": 0.0,
    "FS_SEP_M": 0.0,
}

# They scale with the vessel: a scenario's values belong to its vessels, not to its law.
_OF_THE_VESSEL = ("LAW_KDU", "LAW_KDR")


def parameters(law: Law) -> dict[str, float]:
    """LAW_* parameters of `law`: the paper's gains, or none for the firmware's defaults."""
    return dict(_PAPER) if law == "paper" else {}


def kept(gains: Mapping[str, float], law: str) -> dict[str, float]:
    """Parameters of a hull under `law`; the paper's law drops LAW_* except those of the vessel."""
    return {
        name: value
        for name, value in gains.items()
        if law == "product" or not name.startswith("LAW_") or name in _OF_THE_VESSEL
    }


def impose(law: Law, document: dict[str, Any]) -> None:
    """Set the law of a scenario's document, in place.

    Discards the document's LAW_* gains, for all boats or for one, except LAW_KDU and LAW_KDR. A
    scenario that already has the product's law keeps its gains, which belong to its vessels.
    """
    if law == document.get("law", "product") == "product":
        return
    boats = document.get("boat")
    tables = [document, *(boats if isinstance(boats, list) else [])]
    for table in tables:
        given = table.get("parameters") if isinstance(table, dict) else None
        if isinstance(given, dict):
            for name in [n for n in given if n.startswith("LAW_") and n not in _OF_THE_VESSEL]:
                del given[name]
    document["law"] = law
