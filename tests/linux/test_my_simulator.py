# SPDX-License-Identifier: MIT
"""The example of another simulator steers a boat to its slot."""

import pytest

from sil.examples.my_simulator import sail
from tests.linux.process import PROGRAM


@pytest.mark.filterwarnings("ignore:The 'bustype' argument is deprecated")  # by dronecan
def test_boat_of_another_simulator_sails_to_its_slot(bus: int) -> None:
    if not PROGRAM.exists():
        pytest.skip(f"{PROGRAM} is not built: tools/build release flotillad")
    # a second attempt, as a busy machine may stop the boat
    assert sail(str(PROGRAM), bus) < 0.2 or sail(str(PROGRAM), bus) < 0.2
