# SPDX-License-Identifier: MIT
"""A computer for the doctor to examine."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.flotillad import needs_flotillad
from tests.sil.doctor.patient import Patient


@pytest.fixture
def patient(tmp_path: Path) -> Iterator[Patient]:
    needs_flotillad()
    tmp_path.chmod(0o755)
    patient = Patient(tmp_path)
    yield patient
    patient.close()
