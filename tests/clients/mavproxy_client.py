# SPDX-License-Identifier: MIT
"""MAVProxy with its default modules, in a process that reads commands from a pipe."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from tests.clients.boat import Sea
from tests.linux.process import LOOPBACK

PROGRAM = Path(sys.executable).with_name("mavproxy.py")


class MavProxy:
    """MAVProxy; its files and home directory are `folder`."""

    def __init__(self, sea: Sea, folder: Path) -> None:
        self.sea = sea
        sea.client = self
        self._words = folder / "words"
        environment = {k: v for k, v in os.environ.items() if k != "DISPLAY"}
        with self._words.open("wb") as words:
            self._process = subprocess.Popen(
                [
                    *(sys.executable, "-u", PROGRAM),
                    f"--master=udpin:{LOOPBACK}:{sea.port}",
                    f"--state-basedir={folder}",
                ],
                stdin=subprocess.PIPE,
                stdout=words,
                stderr=subprocess.STDOUT,
                cwd=folder,
                env={**environment, "HOME": str(folder)},
                text=True,
            )

    def close(self) -> None:
        """Close its input, which ends it; a signal would be handled later."""
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    @property
    def words(self) -> str:
        return self._words.read_text(errors="replace")

    def says(self, *parts: str, since: int = 0) -> bool:
        """Whether all parts are in its output after the first `since` characters."""
        words = self.words[since:]
        return all(part in words for part in parts)

    def until_it_says(self, *parts: str, since: int = 0) -> None:
        self.sea.until(lambda: self.says(*parts, since=since))

    def send(self, command: str) -> None:
        """Give a command."""
        assert self._process.stdin is not None
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()

    def tell(self, command: str, *answer: str) -> str:
        """Give a command; the output from then on until it contains all of `answer`."""
        since = len(self.words)
        self.send(command)
        self.until_it_says(*answer, since=since)
        return self.words[since:]
