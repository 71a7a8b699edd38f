# SPDX-License-Identifier: MIT
"""Eight logs of a real BlueBoat, where they are at hand: fitted to one half, scored on the other.

FLOTILLA_BLUEBOAT names their folder (jankristia/BlueBoatSystemIdentification, 10 Hz CSV).
"""

import os
from functools import cache
from pathlib import Path

import pytest

from sil.identify.identification import Identification, identify
from sil.identify.identify_report import remarks, sentence
from sil.identify.log_files import read
from sil.identify.voyage_log import SAMPLE_S
from sil.identify.voyage_model import Body

BESIDE = Path(__file__).parents[4] / "shared" / "data" / "blueboat"
FOLDER = Path(os.environ.get("FLOTILLA_BLUEBOAT", BESIDE))

pytestmark = pytest.mark.skipif(
    not FOLDER.is_dir(),
    reason="not judged: the logs of a real BlueBoat are not part of the project",
)


@cache
def found() -> Identification:
    logs, _ = read(sorted(FOLDER.glob("*.csv")))
    assert len(logs) == 8
    return identify(logs, Body(arm_m=0.28, length_m=1.2, h_s=SAMPLE_S), lambda _: None)


def test_either_half_predicts_the_other() -> None:
    for score in found().held_out:
        assert score is not None
        print(score)
        assert score.windows > 100
        assert score.u > 0.96 and score.r > 0.8 and score.v > 0.45
        assert score.median_m < 1.55 and score.ninetieth_m < 4.0


def test_everything_odd_in_them_is_told() -> None:
    told = " ".join([sentence(found()), *remarks(found())])
    print(told)
    for part in (
        "port pushes astern",
        "port and starboard are swapped",
        "the compass deviates",
        "comes at about 5 Hz",
        "yaw rate look smoothed",
        "the yaw rate is 0.09 s later",
        "acausal",
    ):
        assert part in told
