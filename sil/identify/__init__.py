# SPDX-License-Identifier: MIT
"""Identifies hulls from logs: the unknown terms, and a boat in open loop."""
