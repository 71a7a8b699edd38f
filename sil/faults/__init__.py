# SPDX-License-Identifier: MIT
"""What goes wrong: timed lines of scenarios, and the matrix of faults with its limits."""
