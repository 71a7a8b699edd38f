# SPDX-License-Identifier: MIT
"""The example of another simulator steers a boat to its slot."""

import pytest

from sil.examples.my_simulator import sail
from tests.flotillad import FLOTILLAD, needs_flotillad


@pytest.mark.filterwarnings("ignore:The 'bustype' argument is deprecated")  # by dronecan
def test_boat_of_another_simulator_sails_to_its_slot(bus: int) -> None:
    needs_flotillad()
    # a second attempt, as a busy machine may stop the boat
    assert sail(str(FLOTILLAD), bus) < 0.2 or sail(str(FLOTILLAD), bus) < 0.2
