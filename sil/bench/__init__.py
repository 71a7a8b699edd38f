# SPDX-License-Identifier: MIT
"""Benchmarks of the firmware, the simulation and the page."""
