# SPDX-License-Identifier: MIT
"""Sails scenarios in lockstep: firmware and plant advance tick by tick."""
