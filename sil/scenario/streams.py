# SPDX-License-Identifier: MIT
"""Independent random numbers from a scenario's one seed: what draws from one moves no other."""

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """Who draws; the numbers stay, or every digest changes."""

    CLOCKS = 0
    SENSORS = 1
    LINKS = 2
    MISMATCH = 3
    WHITE_NOISE = 4
    GUSTS = 5
    WAVES = 6
    FAULTS = 7
    SENSOR_DRIFT = 8


# As `sil.plant.sensors.Sensors` takes them.
SENSOR_STREAMS = (Stream.SENSORS, Stream.SENSOR_DRIFT)


def generator(seed: int, stream: Stream) -> np.random.Generator:
    """The random numbers of `stream` in a run with `seed`, from the first one on."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(stream),)))
