# SPDX-License-Identifier: MIT
"""Sails a scenario in real time, a flotillad process a boat."""
