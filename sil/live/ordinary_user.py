# SPDX-License-Identifier: MIT
"""flotillad does not run as root, and in many a container there is nobody else."""

import os

NOBODY = 65534


def ordinary_user() -> list[str]:
    """Words before a program that make it another user's where we are root: setpriv (util-linux).

    Nobody's, and without a right of root's but one: it gets at the files of the run, which are
    root's (CAP_DAC_OVERRIDE).
    """
    if os.geteuid() != 0:
        return []
    one = "-all,+dac_override"
    capabilities = [f"--{which}={one}" for which in ("inh-caps", "ambient-caps", "bounding-set")]
    return ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", *capabilities]
