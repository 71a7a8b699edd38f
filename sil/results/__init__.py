# SPDX-License-Identifier: MIT
"""The published results: the runs, their limits, their pages."""

SEEDS = 40
"""Number of fleets with unknown hulls that each published figure is based on."""
