# SPDX-License-Identifier: MIT
"""tools/with-vcan seen from outside; tests/vcan tests the interfaces from inside."""

import os
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeAlias

import pytest

TOOL = str(Path(__file__).parents[2] / "tools" / "with-vcan")
TIMEOUT_S = 60
IMPOSSIBLE = 77

Tool: TypeAlias = subprocess.Popen[str]
Begin: TypeAlias = Callable[..., Tool]

EVERYTHING = """
printf '[%s]' "$@"; echo
pwd; echo "$BOAT"; ip -brief link | cut -d' ' -f1 | tr '\\n' ' '; echo
candump -L -n 1 -T 5000 vcan0 >heard & dumping=$!
until grep -q '^ *vcan0 ' /proc/net/can/rcvlist_all; do :; done
cansend vcan0 0704060A#FF7C0200C1
wait $dumping
echo "not well" >&2
exit 3
"""
ENDLESS = "trap 'echo stopped; exit 7' TERM; echo sailing; while :; do :; done"
PANIC = "echo hello; grep -q 'User Mode Linux' /proc/cpuinfo && echo c >/proc/sysrq-trigger"


@pytest.fixture(autouse=True)
def _nothing_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Fails if the tool leaves files or processes; its kernel has the folder in its arguments."""
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    yield
    assert not list(temporary.iterdir())
    for arguments in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            assert bytes(temporary) not in arguments.read_bytes()
        except OSError:  # a process of others that has ended
            continue


@pytest.fixture
def begin() -> Iterator[Begin]:
    """Starts the tool without a terminal, and ends it with the test."""
    with ExitStack() as tools:

        def begin(*arguments: str, cwd: Path | None = None) -> Tool:
            tool = subprocess.Popen(
                [TOOL, *arguments],
                cwd=cwd,
                text=True,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
            tools.callback(stop, tool)
            return tool

        yield begin


def stop(tool: Tool) -> None:
    """Ends the tool if it still runs."""
    tool.terminate()
    try:
        tool.communicate(timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        tool.kill()
        tool.communicate()


def end(tool: Tool) -> tuple[int, str, str]:
    """Exit status, output and errors; skips the test if vcan is unavailable."""
    out, err = tool.communicate(timeout=TIMEOUT_S)
    if tool.returncode == IMPOSSIBLE:
        pytest.skip(err)
    return tool.returncode, out, err


def first_line(tool: Tool) -> str:
    """The running command's first line of output; skips as `end` does."""
    assert tool.stdout is not None
    if not select.select([tool.stdout], [], [], TIMEOUT_S)[0]:
        tool.kill()
    line = tool.stdout.readline()
    if not line:
        pytest.fail(f"no output: {end(tool)}")
    return line


def test_a_command_runs_as_if_the_machine_had_vcan(
    begin: Begin, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BOAT", "Meltemi, 2")
    odd = ["two words", "it's", '"so"', "$HOME", "", "new\nline", "ψ", "-n", "--"]
    status, out, err = end(begin("sh", "-c", EVERYTHING, "sh", *odd, cwd=tmp_path))
    assert (status, err) == (3, "not well\n")
    said = "".join(f"[{word}]" for word in odd)
    assert out == f"{said}\n{tmp_path}\nMeltemi, 2\nlo vcan0 vcan1 vcan2 vcan3 \n"
    assert (tmp_path / "heard").read_text().endswith("vcan0 0704060A#FF7C0200C1\n")


def test_two_machines_at_once_have_buses_of_their_own(begin: Begin) -> None:
    names = "ip -brief link | cut -d' ' -f1 | tr '\\n' ' '; "
    one = begin("-n", "1", "sh", "-c", names + "ip link delete vcan0; kill -9 $$")
    two = begin("-n", "2", "sh", "-c", names + "ip link show vcan0 >/dev/null")
    (killed, *said_one), said_two = end(one), end(two)
    assert killed in {137, -signal.SIGKILL}, "as a shell says it, or a parent process sees it"
    assert said_one == ["lo vcan0 ", ""]
    assert said_two == (0, "lo vcan0 vcan1 ", "")


def test_background_processes_of_a_command_end_with_its_machine(begin: Begin) -> None:
    left = begin("--uml", "-n", "1", "sh", "-c", "sleep 1000 & echo done")
    assert end(left) == (0, "done\n", "")


def test_output_comes_live_and_a_signal_reaches_the_command(begin: Begin) -> None:
    tool = begin("-n", "1", "sh", "-c", ENDLESS)
    assert first_line(tool) == "sailing\n"
    tool.terminate()
    assert end(tool)[:2] == (7, "stopped\n")


def test_a_killed_tool_takes_its_kernel_with_it(begin: Begin) -> None:
    tool = begin("--uml", "-n", "1", "sh", "-c", ENDLESS)
    first_line(tool)
    watched = [os.pidfd_open(pid) for pid in descendants(tool.pid)]
    assert len(watched) > 1, "the guard and the kernel"
    tool.kill()
    assert end(tool)[0] == -signal.SIGKILL
    for process in watched:
        assert select.select([process], [], [], TIMEOUT_S)[0]
        os.close(process)


def descendants(pid: int) -> list[int]:
    """All child processes, recursively."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [other for child in map(int, children) for other in [child, *descendants(child)]]


def test_a_kernel_panic_ends_with_status_1_and_the_kernels_last_lines(begin: Begin) -> None:
    status, out, err = end(begin("--uml", "-n", "1", "sh", "-c", PANIC))
    assert (status, out) == (1, "hello\n")
    assert err.startswith("Kernel panic - not syncing: sysrq triggered crash")
    assert err.endswith("with-vcan: the kernel died\n")


def test_a_machine_that_cannot_have_vcan_names_the_missing_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    command = [sys.executable, TOOL, "--uml", sys.executable, "--version"]
    told = subprocess.run(command, check=False, capture_output=True, text=True)
    assert (told.returncode, told.stdout) == (IMPOSSIBLE, "")
    assert "apt-get install" in told.stderr
    assert "user-mode-linux" in told.stderr


@pytest.mark.parametrize(
    ("arguments", "status"), [(["no-such-program"], 127), ([], 2), (["-n", "0", "true"], 2)]
)
def test_a_mistake_is_reported_without_a_boot(
    begin: Begin, arguments: list[str], status: int
) -> None:
    got, out, err = end(begin(*arguments))
    assert (got, out) == (status, "")
    assert "with-vcan" in err
