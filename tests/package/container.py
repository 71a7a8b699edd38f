# SPDX-License-Identifier: MIT
"""Runs an unpacked image by runc, with what Docker gives a container on the host's network.

container BUNDLE [NAME=VALUE…] [WORD…] /usr/share/flotilla/start [OPTION…]: words before the program
are left out, as a container changes its user itself; a --state-dir is mounted where the image has
it.
"""

import json
import os
import sys
from pathlib import Path

START = "/usr/share/flotilla/start"
STATE = "/var/lib/flotilla"
CAPABILITIES = ["CAP_CHOWN", "CAP_DAC_OVERRIDE", "CAP_FOWNER", "CAP_KILL", "CAP_SETGID"]
CAPABILITIES += ["CAP_SETUID"]


def main(bundle: Path, words: list[str]) -> None:
    """Becomes runc."""
    program = words.index(START)
    config = json.loads((bundle / "config.json").read_text())
    process = config["process"]
    process["terminal"] = False
    process["args"] = [START]
    process["env"] += [word for word in words[:program] if "=" in word and word[0] != "-"]
    process["capabilities"] = dict.fromkeys(("bounding", "effective", "permitted"), CAPABILITIES)
    for option in words[program + 1 :]:
        name, _, value = option.partition("=")
        if name == "--state-dir":
            mount = {"destination": STATE, "type": "bind", "source": value, "options": ["bind"]}
            config["mounts"].append(mount)
        else:
            process["args"].append(option)
    spaces = config["linux"]["namespaces"]
    config["linux"]["namespaces"] = [space for space in spaces if space["type"] != "network"]
    (bundle / "config.json").write_text(json.dumps(config))
    command = ["runc", "--root", str(bundle / "state"), "run", "--bundle", str(bundle)]
    os.execvp("runc", [*command, f"flotilla-{os.getpid()}"])


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
