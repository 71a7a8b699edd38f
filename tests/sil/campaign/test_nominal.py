# SPDX-License-Identifier: MIT
"""The run without the paper's uncertainties and disturbances, at ten samples a second."""

from pathlib import Path

import numpy as np

from sil.campaign import nominal
from sil.lockstep.start import StartError
from sil.lockstep.world import sail
from sil.scenario import scenario


def test_nominal_run_is_the_scenarios_in_hulls_that_are_known_and_without_white_noise(
    tmp_path: Path,
) -> None:
    short = ["duration_s=2", "law='paper'"]
    disturbed = scenario.load("mismatch", short)
    assert disturbed.mismatch.share and disturbed.white_noise.power
    assert nominal.write(tmp_path, disturbed, {"LAW_KX": 0.3})
    kept = nominal.read(tmp_path)
    (plain,) = sail([scenario.load("diamond", short)], {"LAW_KX": 0.3})
    assert kept is not None and not isinstance(plain, StartError)
    np.testing.assert_allclose(kept["t_s"], 0.1 * np.arange(21), atol=1e-9)
    for name in ("eta", "error"):
        np.testing.assert_array_equal(kept[name], plain.trace[name][::10])


def test_boats_that_cannot_be_started_leave_no_nominal_run(tmp_path: Path) -> None:
    chosen = scenario.load("straight", ["duration_s=2"])
    (tmp_path / nominal.NAME).write_bytes(b"of another campaign")
    assert not nominal.write(tmp_path, chosen, {"LAW_KX": 9.0})
    assert nominal.read(tmp_path) is None
