# SPDX-License-Identifier: MIT
"""Scenario files: read, checked, and turned into agents, bodies and links."""
