# SPDX-License-Identifier: MIT
"""Sails scenarios in lockstep: the firmware and the plant, tick by tick."""
