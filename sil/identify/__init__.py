# SPDX-License-Identifier: MIT
"""Parts of an identification of hulls from logs: what to find, and a boat in open loop."""
