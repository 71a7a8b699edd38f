# SPDX-License-Identifier: MIT
"""python -m flotilla_usv: the same as flotilla."""

import sys

from sil.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
