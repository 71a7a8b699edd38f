# SPDX-License-Identifier: MIT
"""tools/faults: sails the matrix of faults, and says which limits were kept."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import rich.progress
from rich.console import Console

from sil.faults import matrix, rows, told


def main(arguments: Sequence[str]) -> int:
    """Exit status: 0 all limits kept, 1 not all, 2 a mistake of the caller, told in one line."""
    parser = argparse.ArgumentParser(prog="tools/faults", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/faults"), help="(out/faults)")
    parser.add_argument("--only", metavar="NAME", help="rows whose names have this in them")
    options = parser.parse_args(arguments)
    console = Console()
    try:
        chosen = [row for row in rows.read() if options.only is None or options.only in row.name]
        if not chosen:
            raise ValueError(f'no fault has "{options.only}" in its name')
        bar = rich.progress.Progress(console=console)
        with bar:
            task = bar.add_task(f"{len(chosen)} faults", total=1.0)
            done = matrix.sail_all(chosen, lambda share: bar.update(task, completed=share))
        console.print(told.table(done))
        told.write(options.out, done)
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    console.print(f"results: {options.out}/faults.md", soft_wrap=True)
    print(told.summary(done))
    return int(not all(one.passed for one in done))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
