# SPDX-License-Identifier: MIT
"""The laws that a scenario can be sailed with: sets of LAW_* parameters."""

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

# In units of a vessel: what a scenario says of them belongs to its vessels, not to its law.
_OF_THE_VESSEL = ("LAW_KDU", "LAW_KDR")


def parameters(law: Law) -> dict[str, float]:
    """What `law` tells the firmware: the paper's gains, or nothing but its own defaults."""
    return dict(_PAPER) if law == "paper" else {}


def impose(law: Law, document: dict[str, Any]) -> None:
    """Make `law` that of a scenario's document, in place.

    What the document says of LAW_* for all or for one boat goes, but for LAW_KDU and LAW_KDR. A
    scenario that has the product's law already keeps what it says for its vessels.
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
