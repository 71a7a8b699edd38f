# SPDX-License-Identifier: MIT
"""A batch of runs: each equal to the run alone, whatever happens to the others."""

from dataclasses import replace
from pathlib import Path

import pytest

from sil.campaign.run_outcome import RunResult
from sil.campaign.work import OtherCodeError, sail_batch
from tests.sil.campaign.short import batch, sampler
from tests.turns import some


def same(one: RunResult, other: RunResult) -> bool:
    return repr(one) == repr(other) and one.error_m.tobytes() == other.error_m.tobytes()


def test_a_run_beside_others_equals_the_run_alone(tmp_path: Path) -> None:
    made = sampler(tmp_path)
    together = sail_batch(batch(made, (0, 1, 5)))
    assert [run.run for run in together.runs] == [0, 1, 5] and together.busy_s > 0.0
    assert len({run.digest for run in together.runs}) == 3
    for run in together.runs:
        assert run.outcome == "ok" and run.seed == made.seed_of(run.run)
        assert same(sail_batch(batch(made, (run.run,))).runs[0], run)


def test_a_run_that_the_firmware_refuses_has_failed_and_costs_no_other(tmp_path: Path) -> None:
    calm = sail_batch(batch(sampler(tmp_path), (0, 1, 2, 3))).runs
    refused = '[[vary]]\nkey = "boat.2.parameters.THR_ARM"\nchoice = [0.25, 100.0]\n'
    made = sampler(tmp_path, refused)
    wide = [run for run in range(4) if made.draws(run)["boat.2.parameters.THR_ARM"] == 100.0]
    assert 0 < len(wide) < 4
    for run in some(sail_batch(batch(made, (0, 1, 2, 3))).runs):
        if run.run in wide:
            assert run.outcome == "failed" and "THR_ARM" in run.reason and run.boats == ()
            assert run.seed == made.seed_of(run.run)
        else:
            assert same(run, calm[run.run])


def test_boats_that_cannot_start_have_failed_with_the_reason(tmp_path: Path) -> None:
    lost = sail_batch(batch(sampler(tmp_path, "", ("link.loss=1.0",)), (0,))).runs[0]
    assert lost.outcome == "failed" and "not in the wanted mode" in lost.reason


def test_a_worker_with_other_code_refuses_the_batch(tmp_path: Path) -> None:
    with pytest.raises(OtherCodeError):
        sail_batch(replace(batch(sampler(tmp_path), (0,)), code="other"))
