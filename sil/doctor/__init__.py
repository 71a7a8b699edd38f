# SPDX-License-Identifier: MIT
"""Finds faults of a boat's computer that keep the boat from sailing, and names the remedy."""
