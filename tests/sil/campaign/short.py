# SPDX-License-Identifier: MIT
"""A short campaign: two boats, one second, draws of several kinds."""

from pathlib import Path

import numpy as np

from sil.campaign.run_outcome import RunResult
from sil.campaign.sampling import Sampler
from sil.campaign.work import Share, code
from sil.plant.hull import Array
from sil.scenario import scenario

SHORT = """\
base = "diamond"
duration_s = 2.0
[white_noise]
power = 0.1
[[vary]]
key = "boat.*.eta"
normal = [0.0, 5.0]
[[vary]]
key = "parameters.LAW_KX"
uniform = [0.5, 1.5]
combine = "scale"
[[vary]]
key = "navigation.message"
choice = ["local", "odometry"]
"""


def short(folder: Path, more: str = "") -> Path:
    """Path of a file with that scenario and `more`."""
    path = folder / "short.toml"
    path.write_text(SHORT + more, encoding="utf-8")
    return path


def sampler(folder: Path, more: str = "", overrides: tuple[str, ...] = ()) -> Sampler:
    return Sampler(scenario.read(short(folder, more), overrides))


def batch(sampler: Sampler, runs: tuple[int, ...]) -> Share:
    return Share(runs, sampler, {}, code())


def result(run: int, error_m: list[list[float]], outcome: str = "ok") -> RunResult:
    """A made-up run with the given distances (N, S)."""
    boats = tuple(
        {"rms_error_m": 0.1 * run + i, "settling_time_s": None} for i in range(len(error_m))
    )
    states = tuple({"FORMATION": 1.0} for _ in error_m)
    samples: Array = np.array(error_m, np.float32)
    return RunResult(run, 7, outcome, "", "d", 1.0, boats, states, samples, 0.5 * samples)
