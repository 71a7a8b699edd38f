# SPDX-License-Identifier: MIT
"""tools/view: a page that shows a fleet, as it sails now or as it was recorded. It only listens."""

import argparse
import sys
from collections.abc import Sequence

from sil.view.live import Live
from sil.view.serve import serve
from sil.wire.mavlink_mcast import LOOPBACK, host_and_port

_SOURCE = """\
mcast:[GROUP:PORT[:ADDRESS]], udpin:HOST:PORT, tcp:HOST:PORT, /dev/TTY[:BAUD]: a live fleet"""


def main(arguments: Sequence[str]) -> int:
    """Exit status: 0 when interrupted, 2 for a mistake of the caller, in one line."""
    parser = argparse.ArgumentParser(prog="tools/view", description=__doc__)
    parser.add_argument("source", help=_SOURCE)
    parser.add_argument(
        "--bind",
        default=f"{LOOPBACK}:8321",
        metavar="HOST:PORT",
        help="where the page is served (127.0.0.1:8321); with 0.0.0.0:8321 who can reach this "
        "machine sees it",
    )
    parser.add_argument(
        "--length", type=float, default=1.0, metavar="M", help="of boats, for the plan view (1 m)"
    )
    options = parser.parse_args(arguments)
    try:
        bind = host_and_port(options.bind, least=0)
        serve(Live(options.source, options.length), bind)
    except KeyboardInterrupt:
        return 0
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
