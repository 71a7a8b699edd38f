# SPDX-License-Identifier: MIT
"""The command line: flotilla COMMAND, or python -m sil COMMAND."""

import argparse
import difflib
import errno
import gc
import os
import signal
import sys
from collections.abc import Sequence
from importlib import import_module

from sil import ROOT
from sil.common import standard_streams

_VERBS = {
    "demo": "four boats sail boat 1's plan; --live: in real time, shown in the browser",
    "run": "sail a scenario in lockstep, as fast as possible",
    "live": "sail a scenario in real time, one flotillad process per boat",
    "campaign": "sail a scenario many times, each run with its own draws",
    "compare": "compare two campaigns: is the second worse than the first?",
    "identify": "identify a hull from logs of its sailing: a parameter file, a page",
    "certify": "check before sailing whether the gains hold the formation",
    "view": "show a fleet in the browser, live or recorded",
    "fleet": "command a fleet: arm it, form it, send it off, stop it",
    "doctor": "check a boat's computer: what keeps the boat from sailing",
    "scenarios": "list the scenarios, or print one as a start for your own",
    "hulls": "list the hulls that a scenario may name, or print one's parameters",
    "convert": "convert logs to an MCAP file for Foxglove, Lichtblick and Rerun",
    "replay": "replay a recording to its boats, and compare the answers bit for bit",
    "faults": "sail the matrix of faults, or hours of random ones",
    "bench": "time the firmware and the simulation, count instructions",
    "rivals": "compare Flotilla with other ways to follow a plan",
    "results": "sail all published scenarios, and renew their pages",
}
# The extra of pyproject.toml that installs a module.
_EXTRAS = {
    "matplotlib": "view",
    "PIL": "view",
    "tornado": "view",
    "pyarrow": "campaign",
    "scipy": "campaign",
    "distributed": "cluster",
    "foxglove": "logs",
    "google": "logs",
    "casadi": "rivals",
    "psutil": "dev",
}
# Each of these builds its program before it runs it.
_TOOLS = {
    "fuzz": "feed random bytes, frames, files and histories to the firmware",
    "fixed": "check the errors of the fixed-point functions for every argument",
    "metal": "play a stream to a Cortex-M4 under qemu; instructions and memory",
    "flakes": "repeat tests and runs, and find those whose results differ",
    "reference": "renew the generated tables of the firmware's pages",
}
_INTERRUPTED = 130
_OBJECTS = 50_000  # new objects, before the collector looks for unreachable cycles


def main(given: Sequence[str] | None = None) -> int:
    """Run a command; returns its exit status.

    0 on success, 1 if a limit was missed, 2 after a mistake of the caller, 130 if interrupted.
    """
    if given is None:
        # SIGTERM ends a live run as Ctrl-C does, so that the boats' processes end too.
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        # With Python's threshold of 700, the garbage collector takes a tenth of the time in which a
        # verb's modules load.
        gc.set_threshold(_OBJECTS)
        standard_streams.make_patient()
        given = sys.argv[1:]
    given = list(given)
    if not given or given[0] in ("-h", "--help"):
        print(_overview())
        return 0 if given else 2
    if given[0] == "--version":
        print(f"flotilla {import_module('flotilla').__version__}")
        return 0
    verb, *others = given
    try:
        if verb in _TOOLS:
            return _tool(verb, others)
        if verb not in _VERBS:
            raise ValueError(f'unknown command "{verb}"{_near(verb)}; flotilla --help lists them')
        command = import_module(f"sil.cli.{verb}_command")
        parser = argparse.ArgumentParser(
            prog=f"flotilla {verb}",
            description=command.__doc__,
            epilog="examples:\n" + "".join(f"  {line}\n" for line in command.EXAMPLES),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        command.add_to(parser)
        options, further = parser.parse_known_intermixed_args(others)
        if further and verb != "demo":  # demo passes them on
            parser.error(f"unrecognized arguments: {' '.join(further)}")
        status: int = command.main(options, given)
        standard_streams.check()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return _INTERRUPTED
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        if module not in _EXTRAS:
            raise
        remedy = f"pip install 'flotilla-usv[{_EXTRAS[module]}]'"
        print(f"error: flotilla {verb} needs {module}: {remedy}", file=sys.stderr)
        return 2
    except MemoryError as error:
        told = f": {error}" if str(error) else ""
        print(
            f"error: not enough memory{told}; sail fewer boats, or for less time", file=sys.stderr
        )
        return 2
    except (OSError, ValueError) as error:
        print(f"error: {sentence(error)}", file=sys.stderr)
        return 2
    return status


def sentence(error: Exception) -> str:
    """The error's cause, place and remedy, without the operating system's error numbers."""
    if not isinstance(error, OSError) or error.errno is None:
        return str(error)
    if error.errno == errno.EAFNOSUPPORT:
        return (
            "this kernel has no CAN sockets (AF_CAN): run the command under tools/with-vcan, "
            "or use --bus mcast:0"
        )
    if error.errno == errno.ENODEV:
        return "there is no such CAN interface: ip link lists them; tools/with-vcan provides vcan0"
    place = f"{error.filename}: " if error.filename else ""
    return f"{place}{error.strerror}"


def _overview() -> str:
    lines = ["usage: flotilla COMMAND …; flotilla COMMAND --help has examples", ""]
    for verbs in (_VERBS, _TOOLS):
        lines += [f"  {verb:11}{what}" for verb, what in verbs.items()] + [""]
    return "\n".join(lines).rstrip()


def _near(verb: str) -> str:
    near = difflib.get_close_matches(verb, [*_VERBS, *_TOOLS], 1)
    return f'; did you mean "{near[0]}"?' if near else ""


def _tool(name: str, arguments: Sequence[str]) -> int:
    path = ROOT / "tools" / name
    if not path.exists():
        raise ValueError(f"{name} needs the project's source tree: {path} does not exist")
    sys.stdout.flush()
    os.execv(path, [str(path), *arguments])  # noqa: S606
