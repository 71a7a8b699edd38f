# SPDX-License-Identifier: MIT
"""Converts boats' logs or a run's folder to MCAP for Foxglove, Lichtblick or Rerun."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import rich.progress
from rich.console import Console
from rich.markup import escape

from sil.common import files
from sil.lockstep.recording import MAGIC
from sil.logs import boats, run_folder


def convert(logs: Sequence[Path], wanted: Path | None, console: Console) -> None:
    """Convert logs, or one run's folder, to `wanted`, by default beside the first log.

    ValueError or OSError if they cannot be converted; then nothing is written.
    """
    runs = [path for path in logs if (path / "trace.npz").exists()]
    if runs and len(logs) > 1:
        raise ValueError(f"{runs[0]} is the folder of a run: convert it separately")
    if runs:
        out = _place(wanted or runs[0] / run_folder.NAME)
        inside = out.resolve().is_relative_to(runs[0].resolve())
        if out.suffix != ".mcap" and out.exists() and inside:
            raise ValueError(f"{out} is a file of the run to convert: choose another --out")
        with bar(out, console) as progress:
            messages = run_folder.convert(runs[0], out, progress)
        console.print(f"{out}: {messages} messages", soft_wrap=True, markup=False)
        return
    tlogs, candumps = _sorted_out(logs)
    out = _place(wanted or (tlogs or candumps)[0].with_suffix(".mcap"))
    if any(out.exists() and out.samefile(log) for log in (*tlogs, *candumps)):
        raise ValueError(f"{out} is one of the logs to convert: choose another --out")
    with bar(out, console) as progress:
        done = boats.convert(tlogs, candumps, out, progress)
    told = ", ".join(done.vessels)
    console.print(f"{out}: {done.messages} messages of {told}", soft_wrap=True, markup=False)
    if done.damaged:
        console.print(f"[bold red]skipped {done.damaged} damaged bytes of the logs")


def _place(out: Path) -> Path:
    """Return `out`, checked before hours of logs are read in vain.

    ValueError if its folder is missing, OSError if that cannot be written to.
    """
    if not out.parent.is_dir():
        raise ValueError(f"{out.parent}: no such folder")
    if files.is_replaced(out):
        files.check_folder(out.parent, out)
    return out


def _sorted_out(logs: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Telemetry logs and candump logs; of a folder, all in it or in its subfolder `log`."""
    tlogs: list[Path] = []
    candumps: list[Path] = []
    for path in logs:
        if not path.is_dir():
            (candumps if _is_candump(path) else tlogs).append(path)
            continue
        folder = path / "log" if (path / "log").is_dir() else path
        found = sorted(folder.glob("*.tlog")), sorted(folder.glob("can-*.log"))
        if not any(found):
            raise ValueError(f"{path}: neither the folder of a run nor one with logs of a boat")
        tlogs += found[0]
        candumps += found[1]
    return tlogs, candumps


def _is_candump(path: Path) -> bool:
    """Whether the file is a candump log, by its first bytes; ValueError if it is no log."""
    with path.open("rb") as file:
        begin = file.read(len(MAGIC))
    if not begin:
        raise ValueError(f"{path}: the file is empty")
    if begin == MAGIC:
        raise ValueError(f"{path}: the recording of a run; convert its folder, {path.parent}")
    return begin[:1] == b"(" or path.suffix == ".log"


@contextmanager
def bar(out: Path, console: Console) -> Iterator[boats.Progress]:
    """Show a progress bar for `out`."""
    with rich.progress.Progress(console=console, transient=True) as shown:
        task = shown.add_task(escape(out.name), total=1.0)
        yield lambda share: shown.update(task, completed=share)
