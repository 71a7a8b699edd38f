# SPDX-License-Identifier: MIT
"""The command line: python -m sil run, live, campaign, compare, results; each has a --help."""

import argparse
import importlib
import sys
from collections.abc import Sequence

_MODULES = {
    "run": "sil.cli.commands",
    "live": "sil.cli.commands",
    "results": "sil.results.results",
    "campaign": "sil.campaign.command",
    "compare": "sil.campaign.compare",
}


def main(arguments: Sequence[str]) -> int:
    """Exit status of the command, as its module's `main` says; 2 mistaken, 130 interrupted."""
    parser = argparse.ArgumentParser(prog="python -m sil", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    # A command imports no more than it needs; help needs them all.
    named = [_MODULES[name] for name in arguments[:1] if name in _MODULES]
    for name in dict.fromkeys(named or _MODULES.values()):
        importlib.import_module(name).add_to(commands)
    options = parser.parse_args(arguments)
    status: int = importlib.import_module(_MODULES[options.command]).main(options, arguments)
    return status


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
