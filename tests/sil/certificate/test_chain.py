# SPDX-License-Identifier: MIT
"""Chains: the certified depth is the depth to which they hold in simulation."""

from functools import cache

import pytest

from sil.certificate import agreement, chain
from sil.certificate.references import references
from sil.scenario import scenario
from sil.scenario.law import Law


@pytest.mark.parametrize("delay_s", agreement.DELAYS_S)
@pytest.mark.parametrize("law", ["product", "paper"])
def test_a_chain_breaks_in_simulation_where_it_stops_being_certified(
    law: Law, delay_s: float
) -> None:
    found = agreement.compare("line10", law, {"LAW_REF": 0.0}, delay_s)
    assert found.agree, found
    assert 0 < found.certified < 10, found


@cache
def followed(delay_s: float) -> chain.Chain:
    """Boats of which each follows the one before it."""
    late = scenario.load("line10", [f"link.delay_s={delay_s}"])
    return chain.chain(late, references(late)[0], {"LAW_REF": 0.0})


def test_each_hop_amplifies_more_the_later_the_radio_is() -> None:
    most = [max(followed(delay_s).yaw.hop) for delay_s in (0.0, 0.1, 0.2)]
    assert most == pytest.approx([1.56, 2.1, 2.8], abs=0.15)  # as measured in chains


def test_a_slow_turn_is_passed_on_as_it_is() -> None:
    found = followed(0.2)
    assert found.yaw.hop[0] == pytest.approx(1.0, abs=0.05)
    assert found.surge.hop[0] == pytest.approx(1.0, abs=0.05)
