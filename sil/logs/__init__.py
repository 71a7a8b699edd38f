# SPDX-License-Identifier: MIT
"""Runs and boats' logs as MCAP files, which other people's programs open; sil/docs/LOGS.md."""
