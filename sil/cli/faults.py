# SPDX-License-Identifier: MIT
"""tools/faults: sails the matrix of faults, and says which limits were kept."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import rich.progress
from rich.console import Console

from sil.faults import fault_report, live_matrix, matrix, rows
from sil.faults.soak import Soaked, soak
from sil.lockstep.start import StartError

_INTERRUPTED = 130


def main(arguments: Sequence[str]) -> int:
    """Exit status: 0 all limits kept, 1 not all, 130 interrupted; 2 a mistake, told in one line."""
    parser = argparse.ArgumentParser(prog="tools/faults", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/faults"), help="(out/faults)")
    parser.add_argument("--only", metavar="NAME", help="rows whose names have this in them")
    parser.add_argument(
        "--live", action="store_true", help="the live rows as well: flotillad on a vcan, real time"
    )
    parser.add_argument("--soak", metavar="HOURS", type=float, help="random faults for so long")
    parser.add_argument("--seed", type=int, default=1, help="of the soak's random numbers (1)")
    options = parser.parse_args(arguments)
    console = Console()
    try:
        if options.soak is not None:
            return _soak(options.soak, options.seed, console)
        chosen = [row for row in rows.read() if options.only is None or options.only in row.name]
        if not chosen:
            raise ValueError(f'no fault has "{options.only}" in its name')
        bar = rich.progress.Progress(console=console)
        with bar:
            task = bar.add_task(f"{len(chosen)} faults", total=1.0)
            done = matrix.sail_all(chosen, lambda share: bar.update(task, completed=share))
            if options.live:
                again = bar.add_task("live faults", total=1.0)
                done += live_matrix.rows(lambda share: bar.update(again, completed=share))
        console.print(fault_report.table(done))
        fault_report.write(options.out, done)
    except (ValueError, OSError, StartError, live_matrix.NoVcanError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return _INTERRUPTED
    console.print(f"results: {options.out}/faults.md", soft_wrap=True)
    print(fault_report.summary(done))
    return int(not all(one.passed for one in done))


def _soak(hours: float, seed: int, console: Console) -> int:
    if not hours > 0.0:
        raise ValueError(f"--soak {hours:g}: must be positive")
    bar = rich.progress.Progress(console=console)
    with bar:
        task = bar.add_task(f"{hours:g} h of faults", total=1.0)

        def show(share: float, soaked: Soaked) -> None:
            label = f"{hours:g} h: {soaked.faults.total()} faults, {soaked.resident_MB[-1]:.0f} MB"
            bar.update(task, completed=share, description=label)

        soaked = soak(hours, seed, show)
    console.print(fault_report.soak_table(soaked))
    console.print("resident, MB:", " ".join(f"{size:.1f}" for size in soaked.resident_MB))
    for wrong in soaked.wrong:
        console.print(f"[bold red]{wrong}")
    console.print(f"seed {seed}, digest {soaked.digest}")
    failed = len(soaked.wrong)
    print(f"{soaked.faults.total() - failed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
