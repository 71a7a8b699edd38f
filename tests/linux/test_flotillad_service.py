# SPDX-License-Identifier: MIT
"""The systemd unit: an ordinary user in a sandbox that still lets a boat run."""

import re
import shutil
import subprocess
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.flotillad import FLOTILLAD, needs_flotillad
from tests.linux.process import ROOT

FOLDER = ROOT / "firmware" / "linux"
UNIT = FOLDER / "flotillad.service"
MOST_EXPOSED = 2.0
INSTALLED = Path("/usr/bin/flotillad")


def analyze(*arguments: object) -> subprocess.CompletedProcess[str]:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("needs systemd-analyze: apt-get install systemd")
    words = ["systemd-analyze", *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, timeout=20, check=False)


def settings() -> dict[str, list[str]]:
    """The values of every key, in order."""
    found: dict[str, list[str]] = {}
    for line in UNIT.read_text().splitlines():
        if line[:1].isalpha():
            key, _, value = line.partition("=")
            found.setdefault(key, []).append(value)
    return found


def exposure(unit: Path) -> float:
    """systemd's exposure level: 0 is a perfect sandbox, 10 a service with all rights of root."""
    done = analyze("security", "--offline=true", "--no-pager", unit)
    said = next(line for line in done.stdout.splitlines() if "Overall exposure level" in line)
    return float(said.partition(": ")[2].split()[0])


def test_systemd_rates_the_units_exposure_below_the_limit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    closed = exposure(UNIT)
    with capsys.disabled():
        print(f"\nflotillad.service: exposure {closed} (systemd-analyze security)")
    assert closed < MOST_EXPOSED
    opened = tmp_path / "flotillad.service"
    opened.write_text(UNIT.read_text().replace("CapabilityBoundingSet=\n", ""))
    assert exposure(opened) > closed


@pytest.mark.parametrize(
    ("spoil", "complaint"),
    [
        (lambda text: text, ""),
        (lambda text: text.replace(str(FLOTILLAD), f"{FLOTILLAD}-absent"), "is not executable"),
        (lambda text: text.replace("WatchdogSec=1", "WatchdogSec=soon"), "Failed to parse"),
    ],
)
def test_systemd_understands_every_line(
    tmp_path: Path, spoil: Callable[[str], str], complaint: str
) -> None:
    needs_flotillad()
    unit = tmp_path / "flotillad.service"
    unit.write_text(spoil(UNIT.read_text().replace(str(INSTALLED), str(FLOTILLAD))))
    # The manual is in the package. Other units of this machine may contain mistakes.
    done = analyze("verify", "--man=no", unit)
    said = [line for line in done.stderr.splitlines() if unit.name in line]
    assert any(complaint in line for line in said) if complaint else said == []


def test_the_manual_that_the_unit_names_comes_with_the_package() -> None:
    (page,) = settings()["Documentation"]
    named = re.fullmatch(r"man:(\w+)\((\d)\)", page)
    assert named and (FOLDER / "package" / ".".join(named.groups())).is_file()


def test_the_shipped_configuration_finds_its_folders() -> None:
    unit = settings()
    config = tomllib.loads((FOLDER / "boat.toml").read_text())
    assert unit["ExecStart"] == [f"{INSTALLED} --config /etc/flotilla/boat.toml"]
    assert unit["ConfigurationDirectory"] == ["flotilla"]
    assert config["state-dir"] == f"/var/lib/{unit['StateDirectory'][0]}"
    assert config["log"] == f"/var/log/{unit['LogsDirectory'][0]}"
    assert config["priority"] <= int(unit["LimitRTPRIO"][0])
    assert config["lock-memory"] and unit["LimitMEMLOCK"] == ["infinity"]


def test_the_unit_has_a_watchdog_and_always_restarts_as_an_unprivileged_user() -> None:
    unit = settings()
    assert unit["Type"] == ["notify"] and unit["WatchdogSec"] == ["1"]
    assert unit["Restart"] == ["always"] and unit["StartLimitIntervalSec"] == ["0"]
    assert unit["User"] not in (["root"], ["0"])
    assert unit["OOMScoreAdjust"] == ["-900"]
    assert unit["CapabilityBoundingSet"] == [""] and "AmbientCapabilities" not in unit
