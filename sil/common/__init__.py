# SPDX-License-Identifier: MIT
"""Files and processes; knows nothing of boats."""
