# SPDX-License-Identifier: MIT
"""A flotillad with navigation unit, leader, ESCs and operator, on loopback, until it has thrust.

sail FOLDER PROGRAM STATE-DIR [WORD…]: the words run a command where PROGRAM is. In a network of its
own, whose multicast is on loopback.
"""

import sys
from pathlib import Path

from tests.linux.process import RealSea


def main(folder: str, program: str, state_dir: str, *prefix: str) -> None:
    with RealSea(0, Path(folder)) as sea:
        sea.program, sea.state_dir = Path(program), Path(state_dir)
        sea.start(prefix=prefix)
        sea.save_parameters()  # a new boat arms no sooner
        sea.enter_formation()
        sea.until(lambda: any(sea.raw_commands()[-1]))
        print(f"pushes: {sea.raw_commands()[-1]}")
        print(f"status {sea.end()}: {sea.process.words}")


if __name__ == "__main__":
    main(*sys.argv[1:])
