# SPDX-License-Identifier: MIT
"""Bytes and frames between simulated vessels; contains no physics and no wall time."""
