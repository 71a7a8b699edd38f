# SPDX-License-Identifier: MIT
"""The software-in-the-loop world: plant, sensors, wire, scenarios, metrics, reports."""
