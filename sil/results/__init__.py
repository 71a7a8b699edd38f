# SPDX-License-Identifier: MIT
"""The published results: the runs, their limits, their pages."""
