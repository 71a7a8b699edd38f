# SPDX-License-Identifier: MIT
"""The software-in-the-loop world: plant, sensors, wire, scenarios, metrics, reports."""

import os
from pathlib import Path

# Matrices are small here: OpenBLAS's threads would take time from each other and from the processes
# beside them, and their number would decide the last bits. numpy reads this when it is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parents[1]  # of the source tree
