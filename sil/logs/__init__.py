# SPDX-License-Identifier: MIT
"""Converts runs and boats' logs to MCAP, which common viewers open; sil/docs/LOGS.md."""
