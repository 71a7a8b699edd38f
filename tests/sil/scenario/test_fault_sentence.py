# SPDX-License-Identifier: MIT
"""The terminal's sentence for a fault of a scenario."""

from sil.scenario.sections import Fault


def test_a_fault_is_named_with_its_time() -> None:
    loss = Fault(kind="radio_loss", agent=4, at_s=0.0, value=0.3)
    assert loss.sentence("virtual leader") == "fault: radio_loss 0.3, boat 4, from 0 s to the end"
    silent = Fault(kind="radio_silent", agent=0, at_s=40.0, for_s=3.0)
    said = silent.sentence("virtual leader")
    assert said == "fault: radio_silent, virtual leader, from 40 s for 3 s"
