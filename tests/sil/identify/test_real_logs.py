# SPDX-License-Identifier: MIT
"""Eight logs of a real BlueBoat, where they are at hand: fitted to one half, scored on the other.

FLOTILLA_BLUEBOAT names their folder (jankristia/BlueBoatSystemIdentification, 10 Hz CSV).
"""

import os
from functools import cache
from pathlib import Path

import pytest

from sil.identify import propeller_signs
from sil.identify.identification import Identification, Scores, held_out, identify, split
from sil.identify.identify_report import remarks, sentence
from sil.identify.log_files import read
from sil.identify.output_error import AT_ONCE
from sil.identify.voyage_log import SAMPLE_S, VoyageLog
from sil.identify.voyage_model import Body

BESIDE = Path(__file__).parents[4] / "shared" / "data" / "blueboat"
FOLDER = Path(os.environ.get("FLOTILLA_BLUEBOAT", BESIDE))

pytestmark = pytest.mark.skipif(
    not FOLDER.is_dir(),
    reason="not judged: the logs of a real BlueBoat are not part of the project",
)


BODY = Body(arm_m=0.28, length_m=1.2, h_s=SAMPLE_S)


@cache
def logs() -> list[VoyageLog]:
    found, _ = read(sorted(FOLDER.glob("*.csv")))
    assert len(found) == 8
    return found


@cache
def scores() -> Scores:
    """As `identify` finds them, by the schedule that it prefers."""
    wiring = propeller_signs.find(logs())
    mended = [propeller_signs.mended(log, wiring) for log in logs()]
    return held_out(split(mended), BODY, AT_ONCE, lambda _: None, one_log=False)


@cache
def found() -> Identification:
    return identify(logs(), BODY, lambda _: None)


@pytest.mark.nightly
def test_either_half_predicts_the_other() -> None:
    for score in scores():
        assert score is not None
        print(score)
        assert score.windows > 100
        assert score.u > 0.96 and score.r > 0.8 and score.v > 0.45
        assert score.median_m < 1.55 and score.ninetieth_m < 4.0


@pytest.mark.nightly
def test_the_schedule_whose_halves_predict_each_other_is_used() -> None:
    assert found().held_out == scores()


@pytest.mark.nightly
def test_every_oddity_in_them_is_reported() -> None:
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
