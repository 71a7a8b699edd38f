# SPDX-License-Identifier: MIT
"""Runs a boat on an emulated microcontroller."""
