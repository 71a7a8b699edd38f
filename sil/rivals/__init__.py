# SPDX-License-Identifier: MIT
"""Flotilla beside other ways to sail a plan: the same hull, sensors, propellers and weather."""
