# SPDX-License-Identifier: MIT
"""The table of firmware/docs/MESSAGES.md: the MAVLink messages that boats read and send."""

import re

from firmware.link.mavlink.generate import HERE, dialect, listed
from sil import ROOT

PAGE = ROOT / "firmware" / "docs" / "MESSAGES.md"


def table() -> str:
    """Every message of the firmware's list by number, described in the dialect's words."""
    messages = listed((HERE / "messages.txt").read_text(encoding="utf-8"), dialect())
    lines = ["| number | message | a boat reads it | what it is for |", "|--:|---|---|---|"]
    for message in sorted(messages, key=lambda message: int(message.wire.id)):
        first = re.split(r"\. (?=[A-Z])", " ".join(message.wire.description.split()))[0]
        about = first.rstrip(".").replace("|", "\\|")
        read = "yes" if message.is_read else ""
        lines.append(f"| {message.wire.id} | `{message.wire.name}` | {read} | {about} |")
    return "\n".join(lines)
