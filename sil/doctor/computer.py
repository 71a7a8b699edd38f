# SPDX-License-Identifier: MIT
"""The boat's computer as files: their content, and the permissions of the boat's user.

All paths are looked up under `root`: / on the boat itself, elsewhere the mount point of its card.
"""

import os
import stat
from pathlib import Path

READ, WRITE = 4, 2


class Computer:
    """A computer; `user` runs the service. Without such a user, our own permissions count."""

    def __init__(self, root: Path = Path("/"), user: str = "flotilla") -> None:
        self.root = root
        self.user = user
        self.groups = self._groups_of(user)
        self.uid = self._uid_of(user)

    @property
    def has_user(self) -> bool:
        """Whether the service's user exists."""
        return self.uid is not None

    def at(self, path: str | Path) -> Path:
        """The place of a path of that computer."""
        return self.root / str(path).lstrip("/")

    def read(self, path: str | Path) -> str | None:
        """The file's text without surrounding white space; None if it cannot be read."""
        try:
            return self.at(path).read_text(encoding="utf-8").strip()
        except (OSError, UnicodeDecodeError):
            return None

    def is_hidden(self, path: str | Path) -> bool:
        """Whether the doctor itself may not read the path, or cannot even see whether it exists."""
        try:
            return self.at(path).exists() and not os.access(self.at(path), READ)
        except PermissionError:
            return True

    def may(self, path: str | Path, wanted: int) -> bool:
        """Whether the service's user has the `wanted` permission; OSError if there is no path."""
        status = self.at(path).stat()
        if self.uid is None:
            return os.access(self.at(path), wanted)
        mode = stat.S_IMODE(status.st_mode)
        if status.st_uid == self.uid:
            return mode >> 6 & wanted == wanted
        if self._group_name(status.st_gid) in self.groups:
            return mode >> 3 & wanted == wanted
        return mode & wanted == wanted

    def owner(self, path: str | Path) -> int:
        """The owner's user id; OSError if the path does not exist."""
        return self.at(path).stat().st_uid

    def _uid_of(self, user: str) -> int | None:
        for fields in self._lines("/etc/passwd"):
            if fields[0] == user:
                return int(fields[2])
        return None

    def _groups_of(self, user: str) -> set[str]:
        """Names of the groups that the user belongs to."""
        primary = {fields[3] for fields in self._lines("/etc/passwd") if fields[0] == user}
        return {
            fields[0]
            for fields in self._lines("/etc/group")
            if fields[2] in primary or user in fields[3].split(",")
        }

    def _group_name(self, gid: int) -> str | None:
        names = [fields[0] for fields in self._lines("/etc/group") if fields[2] == str(gid)]
        return names[0] if names else None

    def _lines(self, path: str) -> list[list[str]]:
        """The fields of a file like /etc/passwd."""
        lines = (self.read(path) or "").splitlines()
        return [fields for line in lines if len(fields := line.split(":")) > 3]
