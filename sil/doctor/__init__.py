# SPDX-License-Identifier: MIT
"""What keeps a boat's computer from sailing, and what to do about it."""
