# SPDX-License-Identifier: MIT
"""Software-in-the-loop simulation: plant, sensors, wire, scenarios, metrics, reports."""

import os
from pathlib import Path

# Matrices are small here. Threads of OpenBLAS would slow each other and parallel processes down,
# and their number would change the last bits of results. numpy reads this variable at import.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parents[1]  # of the source tree; in a wheel, flotilla_usv/tree
