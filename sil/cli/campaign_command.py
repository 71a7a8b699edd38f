# SPDX-License-Identifier: MIT
"""Sails a scenario many times, each run with its own draws of [[vary]]: tables, pictures, a page.

The same command continues an interrupted campaign. Exit status: 0; 1 if a boat broke a rule of the
firmware; 2 after a mistake of the caller; 130 if interrupted. A run that diverges or fails is
reported, but does not change the exit status.
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
    parser.add_argument(
        "--runs", type=arguments.count, default=100, metavar="N", help="number of runs (100)"
    )
    arguments.add_workers_to(parser)
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="run on this Dask cluster: tcp://HOST:PORT"
    )
    parser.add_argument(
        "--run",
        type=arguments.number,
        metavar="K",
        help="sail only run K, with its full trace, into DIR/runs/K",
    )


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Sail the campaign; `given`: the command line as the caller typed it."""
    began_s = time.perf_counter()
    for name in ("pyarrow", "matplotlib"):  # imported only after the runs
        if find_spec(name) is None:
            raise ModuleNotFoundError(name=name)
    if options.run is None and options.scheduler is None:
        pool.prepare(["sil.campaign.work"])
    # While the workers import their modules, this process imports its own.
    from sil.campaign import campaign

    return campaign.main(options, given, began_s)
