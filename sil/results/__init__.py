# SPDX-License-Identifier: MIT
"""The published results: what is sailed for them, their limits, their pages."""

SEEDS = 40
"""So many fleets of unknown hulls are sailed for a published figure."""
