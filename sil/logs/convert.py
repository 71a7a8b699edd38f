# SPDX-License-Identifier: MIT
"""Boats' logs, or a run's folder, as an MCAP file for Foxglove, Lichtblick or Rerun."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import rich.progress
from rich.console import Console

from sil.lockstep.recording import MAGIC
from sil.logs import boats, run_folder


def convert(logs: Sequence[Path], wanted: Path | None, console: Console) -> None:
    """Convert logs, or one run's folder, into `wanted` or beside the first of the logs.

    ValueError or OSError for what cannot be converted; nothing is written then.
    """
    runs = [path for path in logs if (path / "trace.npz").exists()]
    if runs and len(logs) > 1:
        raise ValueError(f"{runs[0]} is the folder of a run: it is converted alone")
    if runs:
        out = _place(wanted or runs[0] / run_folder.NAME)
        with bar(out, console) as progress:
            messages = run_folder.convert(runs[0], out, progress)
        console.print(f"{out}: {messages} messages", soft_wrap=True)
        return
    tlogs, candumps = _sorted_out(logs)
    out = _place(wanted or (tlogs or candumps)[0].with_suffix(".mcap"))
    if any(out.exists() and out.samefile(log) for log in (*tlogs, *candumps)):
        raise ValueError(f"{out} is one of the logs: it would be lost")
    with bar(out, console) as progress:
        done = boats.convert(tlogs, candumps, out, progress)
    told = ", ".join(done.vessels)
    console.print(f"{out}: {done.messages} messages of {told}", soft_wrap=True)
    if done.damaged:
        console.print(f"[bold red]{done.damaged} bytes of the logs are damaged, and left out")


def _place(out: Path) -> Path:
    """The same, where a file can be; before hours of logs are read for nothing."""
    if not out.parent.is_dir():
        raise ValueError(f"{out.parent}: there is no such folder")
    return out


def _sorted_out(logs: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Telemetry logs and candump logs; of a folder all that it has, or its folder `log`."""
    tlogs: list[Path] = []
    candumps: list[Path] = []
    for path in logs:
        if not path.is_dir():
            (candumps if _is_candump(path) else tlogs).append(path)
            continue
        folder = path / "log" if (path / "log").is_dir() else path
        found = sorted(folder.glob("*.tlog")), sorted(folder.glob("can-*.log"))
        if not any(found):
            raise ValueError(f"{path}: neither a run's folder nor one with logs of a boat")
        tlogs += found[0]
        candumps += found[1]
    return tlogs, candumps


def _is_candump(path: Path) -> bool:
    """By what the file begins with. ValueError for one that is no log."""
    with path.open("rb") as file:
        begin = file.read(len(MAGIC))
    if not begin:
        raise ValueError(f"{path}: the file is empty")
    if begin == MAGIC:
        raise ValueError(f"{path}: a run's recording; its folder is what can be converted")
    return begin[:1] == b"(" or path.suffix == ".log"


@contextmanager
def bar(out: Path, console: Console) -> Iterator[boats.Progress]:
    """Shows how much of `out` is done."""
    with rich.progress.Progress(console=console, transient=True) as shown:
        task = shown.add_task(out.name, total=1.0)
        yield lambda share: shown.update(task, completed=share)
