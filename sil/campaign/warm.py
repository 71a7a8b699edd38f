# SPDX-License-Identifier: MIT
"""Imported by the process from which workers are forked, so that the plant's kernels are loaded."""

from sil.lockstep.world import sail
from sil.scenario import scenario

sail([scenario.load("diamond", ["duration_s=0.01", "white_noise.power=0.1"])], {})
