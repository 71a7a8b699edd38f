# SPDX-License-Identifier: MIT
"""Runs flotillad as an ordinary user: it refuses root, the only user of many containers."""

import os

NOBODY = 65534


def ordinary_user() -> list[str]:
    """Command prefix that drops root's identity if we are root, by setpriv (util-linux).

    The program then runs as nobody; of root's capabilities it keeps only CAP_DAC_OVERRIDE, because
    the files of the run belong to root.
    """
    if os.geteuid() != 0:
        return []
    one = "-all,+dac_override"
    capabilities = [f"--{which}={one}" for which in ("inh-caps", "ambient-caps", "bounding-set")]
    return ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", *capabilities]
