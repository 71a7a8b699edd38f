# SPDX-License-Identifier: MIT
"""The live rows of the matrix of faults: a flotillad process on vcan0, in real time.

python -m sil.faults.live_matrix sails them, under tools/with-vcan if there is no vcan0, and prints
each outcome; the last line is `N passed, N failed`. Exit status: 0 if all passed, 1 if some failed,
2 if they could not be sailed, 77 if no vcan is available.
"""

import argparse
import json
import socket
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from pydantic import Strict

from sil import ROOT
from sil.faults.fault_outcome import Outcome
from sil.faults.live_outing import INTERFACE, LiveOuting, greatest_N
from sil.faults.live_strikes import DISK_BYTES, STRIKES, Strike
from sil.live.live_world import FLOTILLAD, build, now_us
from sil.lockstep.start import StartError
from sil.lockstep.world import Progress
from sil.scenario.sections import NotNegative, Positive, Section

IMPOSSIBLE = 77

_LIMITS = Path(__file__).with_suffix(".toml")
_SETTLE_S = 1.0
_SPEAK_S = 0.5


class NoVcanError(RuntimeError):
    """Live rows need a vcan interface; the text gives the reason why there is none."""


class Row(Section):
    """A fault that lasts `for_s`, and its limits.

    The fault must be detected within `detected_s`: the boat leaves FORMATION or its propellers
    stop; if `state` is FORMATION, the operator gets a text. `state`: the boat's state after the
    fault, before anybody helps. There must be no thrust later than `off_s` after the detection. The
    boat must recover within `recovered_s` of the fault's end.
    """

    name: str
    for_s: Positive
    detected_s: Positive
    state: str
    off_s: NotNegative
    recovered_s: Positive


class _Limits(Section):
    row: Annotated[tuple[Row, ...], Strict(False)]


def limits() -> tuple[Row, ...]:
    """The rows of live_matrix.toml."""
    return _Limits.model_validate(tomllib.loads(_LIMITS.read_text(encoding="utf-8"))).row


def rows(progress: Progress = lambda _: None) -> list[Outcome]:
    """Sail all rows; NoVcanError, or StartError if the boat does not reach FORMATION."""
    outcomes = []
    words = [str(ROOT / "tools" / "with-vcan"), sys.executable, "-m", __spec__.name, "--json"]
    with subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
        assert process.stdout is not None
        for line in process.stdout:
            outcomes.append(Outcome(**json.loads(line)))
            progress(len(outcomes) / len(limits()))
    if process.returncode == IMPOSSIBLE:
        raise NoVcanError("no vcan on this machine; tools/with-vcan printed the reason above")
    if len(outcomes) != len(limits()):
        raise StartError(f"the live rows ended with status {process.returncode}")
    return outcomes


def sail() -> Iterator[Outcome]:
    """Sail the rows one after the other in this process; requires vcan0."""
    with _disk() as folder, closing(LiveOuting(folder)) as outing:
        outing.begin(FLOTILLAD)
        for row in limits():
            yield _sail(outing, row, STRIKES[row.name])


def _sail(outing: LiveOuting, row: Row, strike: Strike) -> Outcome:
    outing.run_for(_SETTLE_S)
    if not outing.drives():  # on a slow machine the boat may have stopped
        outing.help(outing.drives, 10.0)
    why = [] if outing.drives() else [f"{outing.state} before anything went wrong"]
    begin_us = now_us()
    outing.watch(lambda: strike.noticed(outing))
    strike.begin(outing)
    outing.run_for(row.for_s - 1e-6 * (now_us() - begin_us))
    noticed_us = outing.noticed_us or now_us()
    detected_s = None if outing.noticed_us is None else 1e-6 * (noticed_us - begin_us)
    why += filter(None, [strike.wrong(outing)])
    end_us = now_us()
    strike.end(outing)
    outing.run_for(_SPEAK_S)
    state, thrust_N = outing.state, 0.0
    if row.state != "FORMATION":
        thrust_N = greatest_N(outing.thrust_N, noticed_us + round(1e6 * row.off_s), now_us())
        if any(pushes for t_us, pushes in outing.commands if t_us > end_us):
            why.append("a command from before the fault came after it")
    before_s = 1e-6 * (now_us() - end_us)
    helped_s = outing.help(lambda: strike.well(outing), row.recovered_s + 1.0)
    recovered_s = None if helped_s is None else before_s + helped_s
    why += beyond(row, detected_s, state, thrust_N, recovered_s)
    if recovered_s is None:
        why.append(f"{outing.state}: {outing.text}")
        outing.help(outing.drives, 10.0)
    return Outcome(row.name, detected_s, state, thrust_N, recovered_s, not why, "; ".join(why))


def beyond(
    row: Row, detected_s: float | None, state: str, thrust_N: float, recovered_s: float | None
) -> list[str]:
    """The limits of the row that were missed."""
    why = []
    if detected_s is None or detected_s > row.detected_s:
        why.append(f"noticed after {_seconds(detected_s)}, not {row.detected_s:g} s")
    if state != row.state:
        why.append(f"{state}, not {row.state}")
    if thrust_N > 0.0:
        why.append(f"{thrust_N:.2f} N told where none was wanted")
    if recovered_s is None or recovered_s > row.recovered_s:
        why.append(f"back after {_seconds(recovered_s)}, not {row.recovered_s:g} s")
    return why


def _execute(*command: str) -> None:
    subprocess.run(command, check=True)  # noqa: S603


@contextmanager
def _disk() -> Iterator[Path]:
    """A folder whose subfolder `state` is a small disk."""
    with tempfile.TemporaryDirectory(prefix="flotilla-live-") as name:
        folder = Path(name)
        disk = folder / "state"
        disk.mkdir()
        size = f"size={DISK_BYTES},mode=0777"
        _execute("mount", "-t", "tmpfs", "-o", size, "flotilla", str(disk))
        try:
            yield folder
        finally:
            _execute("umount", "--lazy", str(disk))


def _seconds(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f} s"


def _line(one: Outcome) -> str:
    verdict = "pass" if one.passed else f"FAIL: {one.why}"
    return (
        f"{one.fault:18} noticed {_seconds(one.detected_s):7} {one.state:10} thrust "
        f"{one.thrust_after_N:.2f} N   back {_seconds(one.recovered_s):7} {verdict}"
    )


def main(arguments: Sequence[str]) -> int:
    """Run the module's command line."""
    parser = argparse.ArgumentParser(prog="python -m sil.faults.live_matrix", description=__doc__)
    parser.add_argument("--json", action="store_true", help="sail here, one line of JSON per row")
    inside = parser.parse_args(arguments).json
    if INTERFACE not in {name for _, name in socket.if_nameindex()} and inside:
        print(f"error: no {INTERFACE} here", file=sys.stderr)
        return 2
    try:
        if inside:
            for one in sail():
                print(json.dumps(asdict(one)), flush=True)
            return 0
        build(print)
        outcomes = rows()
    except NoVcanError as error:
        print(f"error: {error}", file=sys.stderr)
        return IMPOSSIBLE
    except (StartError, TimeoutError, RuntimeError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(*map(_line, outcomes), sep="\n")
    passed = sum(one.passed for one in outcomes)
    print(f"{passed} passed, {len(outcomes) - passed} failed")
    return int(passed != len(outcomes))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
