# SPDX-License-Identifier: MIT
"""The boats' colours, the same in every picture, page and log."""

# Okabe and Ito's palette and Tol's wine: distinguishable with every kind of colour vision
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#882255")
BLACK, GREY, FAINT = "#222222", "#666666", "#f4f4f4"
BAD = "#c62828"


def colour_of(boat: int) -> str:
    """The colour of boat 1, 2 and so on."""
    return COLOURS[(boat - 1) % len(COLOURS)]
