# SPDX-License-Identifier: MIT
"""Flotilla in a wheel. Importing this package makes the simulation importable, as `sil`.

`sil` is too general a name for site-packages, so the wheel has it in `flotilla_usv/tree`. In a
clone that folder does not exist, and `sil` is at its usual place.
"""

import sys
from pathlib import Path

_TREE = Path(__file__).parent / "tree"
if _TREE.is_dir() and str(_TREE) not in sys.path:
    sys.path.insert(0, str(_TREE))
