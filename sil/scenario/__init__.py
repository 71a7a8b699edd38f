# SPDX-License-Identifier: MIT
"""Reads and checks scenario files and turns them into agents, bodies and links."""
