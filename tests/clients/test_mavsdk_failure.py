# SPDX-License-Identifier: MIT
"""MAVSDK's failure plugin injects failures around a simulated boat, but not a real one."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from mavsdk.plugins.failure import Failure
from mavsdk.plugins.failure.failure import FailureError, FailureResult, FailureType, FailureUnit

from tests.clients.fleet_sea import FleetSea
from tests.clients.mavsdk_client import MavsdkClient
from tests.target.stations import ACCEPTED, ARM, FORMATION, SET_MODE

GPS, GYRO, MOTOR = FailureUnit.SENSOR_GPS, FailureUnit.SENSOR_GYRO, FailureUnit.SYSTEM_MOTOR
SIGNAL = FailureUnit.SYSTEM_MAVLINK_SIGNAL
OK, OFF, SLOW = FailureType.OK, FailureType.OFF, FailureType.SLOW


class Operator:
    """MAVSDK with its failure plugin."""

    def __init__(self, sea: FleetSea) -> None:
        self.sdk = MavsdkClient(sea)
        self._failure = Failure(self.sdk.system)

    def inject(self, unit: FailureUnit, kind: FailureType, instance: int = 0) -> FailureResult:
        try:
            result: FailureResult = self.sdk.call(self._failure.inject, unit, kind, instance)
        except FailureError as error:
            result = error.result
        return result

    def close(self) -> None:
        self._failure.destroy()
        self.sdk.close()


@pytest.fixture
def simulated() -> Iterator[FleetSea]:
    with closing(FleetSea()) as sea:
        yield sea
        print(sea.words)


@pytest.fixture
def operator(simulated: FleetSea, home: Path) -> Iterator[Operator]:
    with closing(Operator(simulated)) as operator:
        yield operator


@pytest.mark.parametrize("instance", [0, 1, 2])
def test_a_propeller_fails_and_the_boat_sails_on_when_it_is_well(
    simulated: FleetSea, operator: Operator, instance: int
) -> None:
    assert operator.inject(MOTOR, OFF, instance) == FailureResult.SUCCESS
    simulated.until(lambda: simulated.state() == "FAULT")
    assert not simulated.batch.command[0].any()
    assert operator.inject(MOTOR, OK, instance) == FailureResult.SUCCESS
    operator.sdk.call(operator.sdk.action.disarm)
    simulated.until(lambda: simulated.state() == "DISARMED")
    simulated.until(lambda: operator.sdk.command(ARM, 1.0) == ACCEPTED)
    simulated.until(lambda: operator.sdk.command(SET_MODE, 1.0, FORMATION) == ACCEPTED)
    simulated.until(lambda: simulated.state() == "FORMATION" and simulated.batch.command[0].any())


def test_a_navigation_unit_falls_silent(simulated: FleetSea, operator: Operator) -> None:
    assert operator.inject(GPS, OFF) == FailureResult.SUCCESS
    simulated.until(lambda: simulated.state() == "HOLD")
    assert operator.sdk.command(SET_MODE, 1.0, FORMATION) != ACCEPTED
    assert operator.inject(GPS, OK) == FailureResult.SUCCESS
    simulated.until(lambda: operator.sdk.command(SET_MODE, 1.0, FORMATION) == ACCEPTED)
    simulated.until(lambda: simulated.state() == "FORMATION")


def test_a_radio_falls_silent_and_the_follower_notices(
    simulated: FleetSea, operator: Operator
) -> None:
    assert operator.inject(SIGNAL, OFF) == FailureResult.SUCCESS
    simulated.until(lambda: {simulated.state(1), simulated.state(2)} == {"COAST"})
    assert operator.inject(SIGNAL, OK) == FailureResult.SUCCESS
    simulated.until(lambda: simulated.state(1) != "COAST" and simulated.state(2) != "COAST")


def test_an_impossible_failure_is_not_injected(simulated: FleetSea, operator: Operator) -> None:
    assert operator.inject(GYRO, OFF) == FailureResult.UNSUPPORTED
    assert operator.inject(GPS, SLOW) == FailureResult.UNSUPPORTED
    assert operator.inject(MOTOR, OFF, 3) == FailureResult.DENIED
    assert operator.inject(GPS, OFF, 2) == FailureResult.DENIED
    assert simulated.state() == "FORMATION"


def test_a_boat_that_is_not_simulated_obeys_no_injected_failure(mavsdk: MavsdkClient) -> None:
    failure = Failure(mavsdk.system)
    with pytest.raises(FailureError) as refusal:
        mavsdk.call(failure.inject, GPS, OFF, 0)
    assert refusal.value.result == FailureResult.UNSUPPORTED
    failure.destroy()
