# SPDX-License-Identifier: MIT
"""Sails a scenario in real time with one flotillad process per boat."""
