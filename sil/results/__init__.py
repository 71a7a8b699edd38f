# SPDX-License-Identifier: MIT
"""The published results: what is sailed for them, their limits, their pages."""
