# SPDX-License-Identifier: MIT
"""A flotillad that runs has its links: the doctor asks it, as a program of its computer."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from sil.doctor.checkup import examine
from sil.doctor.computer import Computer
from sil.doctor.finding import Finding
from tests.linux.process import RealSea, Udp
from tests.sil.doctor.patient import CONFIG, KEY_FILE, Patient
from tests.target.stations import BOAT

ASKED_BUS = 9


def asked(
    patient: Patient, folder: Path, policy: str, plant: Callable[[], None] = lambda: None
) -> list[Finding]:
    """The doctor's findings while a boat runs whose link has this policy for signatures.

    `plant` is called once the boat runs.
    """
    end = Udp(patient.port)
    patient.configure(
        can=f'"mcast:{ASKED_BUS}"',
        mavlink=f'["{end.option},signing={policy}"]',
        param=f"{{ MAV_SYSID = {BOAT} }}",
    )
    end.option += f",signing={policy}"
    with RealSea(ASKED_BUS, folder) as sea, ThreadPoolExecutor(1) as pool:
        sea.connect(end)
        sea.start(f"--signing-key={patient.at(KEY_FILE)}")
        sea.until(lambda: len(sea.raw_commands()) > 0)
        plant()
        found = pool.submit(lambda: list(examine(Computer(patient.root), CONFIG, 0.5)))
        sea.until(found.done)
        return found.result()


@pytest.mark.parametrize("policy", ["off", "required"])
def test_a_running_boat_reports_its_state_and_unmet_conditions(
    patient: Patient, tmp_path: Path, policy: str
) -> None:
    found = asked(patient, tmp_path, policy)
    told = [f.what for f in found if f.where.startswith("udpin:")]
    assert told[0] == "flotillad answers: DISARMED"
    assert len(told) == 2 and told[1].startswith("flotillad: a message takes ")
    lacking = {f.what for f in found if f.where == "boat"}
    # signatures are required of the navigation unit too, which has none here
    assert ("no recent navigation data" in lacking) == (policy == "required")
    assert not lacking & {
        "an ESC is offline or reports a fault",
        "parameters or fence are not saved",
    }


def test_a_doctor_without_the_key_reports_that_it_needs_it(
    patient: Patient, tmp_path: Path
) -> None:
    found = asked(patient, tmp_path, "required", patient.at(KEY_FILE).unlink)
    silent = next(f for f in found if f"no boat {BOAT} answers" in f.what)
    assert "sudo" in silent.remedy
