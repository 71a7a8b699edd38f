# SPDX-License-Identifier: MIT
"""Sails a scenario many times, each run with its own draws of [[vary]]: tables, pictures, a page.

An interrupted campaign goes on where it was. Exit status: 0, 1 where a boat broke a rule of the
firmware, 2 for a mistake of the caller, 130 interrupted; a run that diverges or fails is told, and
changes no exit status.
"""

import argparse
import time
from collections.abc import Sequence
from importlib.util import find_spec

from sil.common import pool
from sil.scenario import arguments

EXAMPLES = (
    "flotilla campaign paper_monte_carlo --runs 100     # the paper's Monte Carlo",
    "flotilla campaign paper_monte_carlo --run 7        # one of them alone, with full trace",
    "flotilla campaign diamond --scheduler tcp://127.0.0.1:8786   # on a Dask cluster",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_to(parser, out="folder of the results (out/campaign/SCENARIO)")
    parser.add_argument("--runs", type=arguments.count, default=100, metavar="N", help="(100)")
    arguments.add_workers_to(parser)
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask cluster that sails them: tcp://HOST:PORT"
    )
    parser.add_argument(
        "--run", type=int, metavar="K", help="sail run K alone, with full trace, into DIR/runs/K"
    )


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Sail it; `given` is what the caller typed."""
    began_s = time.perf_counter()
    for name in ("pyarrow", "matplotlib"):  # which are imported only after the runs
        if find_spec(name) is None:
            raise ModuleNotFoundError(name=name)
    if options.run is None and options.scheduler is None:
        pool.prepare(["sil.campaign.warm"])
    # While the workers import what they need, so does this process.
    from sil.campaign import campaign

    return campaign.main(options, given, began_s)
