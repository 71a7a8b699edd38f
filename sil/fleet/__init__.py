# SPDX-License-Identifier: MIT
"""A ground station that commands a whole fleet: `flotilla fleet`."""
