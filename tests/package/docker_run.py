# SPDX-License-Identifier: MIT
"""Runs flotillad in a container of a Docker engine, in the foreground.

docker_run SOCKET IMAGE [WORD…] PROGRAM [OPTION…]: words before the program are left out, as a
container changes its user itself; a --state-dir is mounted where the image has it.
"""

import os
import sys

from tests.package.container import START, STATE


def main(socket: str, image: str, words: list[str]) -> None:
    """Becomes docker."""
    command = ["docker", f"--host=unix://{socket}", "run", "--rm", "--network=host"]
    options = []
    for option in words[words.index(START) + 1 :]:
        name, _, value = option.partition("=")
        if name == "--state-dir":
            command.append(f"--volume={value}:{STATE}")
        else:
            options.append(option)
    os.execvp("docker", [*command, image, *options])


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
