# SPDX-License-Identifier: MIT
"""Independent streams of random numbers from a scenario's one seed."""

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """Users of random numbers; never renumber them: that would change every digest."""

    CLOCKS = 0
    SENSORS = 1
    LINKS = 2
    MISMATCH = 3
    WHITE_NOISE = 4
    GUSTS = 5
    WAVES = 6
    FAULTS = 7
    SENSOR_DRIFT = 8


# In the order of the arguments of `sil.plant.sensors.Sensors`.
SENSOR_STREAMS = (Stream.SENSORS, Stream.SENSOR_DRIFT)


def generator(seed: int, stream: Stream) -> np.random.Generator:
    """A new generator of the random numbers of `stream` in a run with `seed`."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(stream),)))
