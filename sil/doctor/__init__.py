# SPDX-License-Identifier: MIT
"""Finds what keeps a boat's computer from sailing, and tells the remedy."""
