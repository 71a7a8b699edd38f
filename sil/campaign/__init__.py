# SPDX-License-Identifier: MIT
"""Campaigns: many runs of one scenario, each with its own draws, and their results."""
