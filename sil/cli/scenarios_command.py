# SPDX-License-Identifier: MIT
"""Lists the scenarios, or prints one as a start for your own.

`diamond` has every key, with its unit and meaning; the others change some of them.
"""

import argparse
from collections.abc import Sequence

EXAMPLES = (
    "flotilla scenarios",
    "flotilla scenarios square > mine.toml; flotilla run mine.toml",
    "flotilla scenarios diamond | less    # every key",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("scenario", nargs="?", help="a name of the list")


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Print the list or the scenario."""
    from sil.scenario import scenario

    if options.scenario is not None:
        print(scenario.path_of(options.scenario).read_text(encoding="utf-8"), end="")
        return 0
    for path in sorted(scenario.FOLDER.glob("*.toml")):
        print(f"{path.stem:22}{scenario.about(path)}")
    return 0
