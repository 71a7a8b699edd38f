# SPDX-License-Identifier: MIT
"""Files, worker processes and colours; independent of boats."""
