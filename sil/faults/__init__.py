# SPDX-License-Identifier: MIT
"""The matrix of faults with its limits, in lockstep and live, and random faults for hours."""
