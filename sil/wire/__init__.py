# SPDX-License-Identifier: MIT
"""What travels between the simulated boats: bytes and frames, without physics or wall time."""
