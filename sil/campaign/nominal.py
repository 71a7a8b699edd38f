# SPDX-License-Identifier: MIT
"""The nominal run of a campaign's scenario, for the report's pictures."""

from pathlib import Path

import numpy as np

from sil.common import files
from sil.lockstep.start import RunError
from sil.lockstep.world import Progress, sail
from sil.plant.hull import Array
from sil.scenario.scenario import Scenario
from sil.scenario.sections import Mismatch, WhiteNoise

NAME = "nominal.npz"
_SAMPLE_S = 0.1


def write(
    out: Path,
    scenario: Scenario,
    parameters: dict[str, float],
    progress: Progress = lambda _: None,
) -> bool:
    """Sail `scenario` and write nominal.npz into the existing folder `out`: t_s, eta, error.

    The run has the scenario's own start, hulls as in the firmware's model, and w = 0: the
    dash-dotted lines of the paper's Fig. 2. Ten samples a second, shapes as in trace.npz.
    `parameters`: firmware parameters that override the scenario's; `progress` is called with the
    share that is done. Returns False, and writes no file, if the boats cannot be started or break a
    rule.
    """
    (out / NAME).unlink(missing_ok=True)
    nominal = {"mismatch": Mismatch(), "white_noise": WhiteNoise()}
    chosen = scenario.model_copy(update=nominal)
    (run,) = sail([chosen], parameters, keep_s=_SAMPLE_S, progress=progress)
    if isinstance(run, RunError):
        return False
    arrays = {key: run.trace[key] for key in ("t_s", "eta", "error")}
    with files.whole(out / NAME) as file:
        # numpy's stubs take any keyword for its own options
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
    return True


def read(out: Path) -> dict[str, Array] | None:
    """The arrays of nominal.npz, None where `out` has none."""
    path = out / NAME
    if not path.is_file():
        return None
    with np.load(path) as arrays:
        return dict(arrays)
