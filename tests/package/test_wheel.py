# SPDX-License-Identifier: MIT
"""The wheel in an empty virtual environment: who has only that sees four boats sail."""

import json
import os
import pty
import re
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from sil.live.ordinary_user import ordinary_user
from tests.live_buses import live_buses
from tests.package.conftest import build
from tests.package.root import SOURCES, need, run
from tests.package.test_release import parts

CORE_MB = 450
#: Printed beside what it took; no test fails on time alone.
FIRST_BOATS_S = 10.0
#: Of the project alone; another distribution brings what else there is.
TOP_LEVEL = {"flotilla.pyi", "flotilla_usv"}


@pytest.fixture(scope="module")
def wheel() -> Path:
    need("g++")
    return build("wheel")


class Newcomer:
    """An environment with the wheel and what it depends on, in a folder that all may read."""

    def __init__(self, folder: Path, wheel: Path) -> None:
        self.folder = folder
        self.python = folder / "venv" / "bin" / "python"
        self.flotilla = self.python.with_name("flotilla")
        run([sys.executable, "-m", "venv", str(folder / "venv")])
        pins = (SOURCES / "tools" / "requirements.txt").read_text(encoding="utf-8")
        (folder / "pins").write_text("\n".join(re.findall(r"^[\w.-]+==[^ \\]+", pins, re.M)))
        # uv compiles no modules, pip all of them; without, the start is the slower one
        words = [str(self.python), "-m", "pip", "install", "--quiet", "--no-compile"]
        run([*words, f"--constraint={folder / 'pins'}", str(wheel)])
        self.core_mb = self._size_mb()

    def run(self, *words: object) -> str:
        """The output of a program, which sees nothing of the clone."""
        done = subprocess.run(
            list(map(str, words)),
            cwd=self.folder,
            env={"PATH": os.environ["PATH"], "HOME": str(self.folder)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
            timeout=120,
        )
        assert done.returncode == 0, done.stdout
        return done.stdout

    def asks(self, program: str) -> str:
        return self.run(self.python, "-c", program).strip()

    def _size_mb(self) -> float:
        """What was installed beside the tools of a new environment."""
        site = Path(self.asks("import sysconfig; print(sysconfig.get_path('platlib'))"))
        ours = [each for each in site.iterdir() if not each.name.startswith(("pip", "setuptools"))]
        files = [file for each in ours for file in (each, *each.rglob("*")) if file.is_file()]
        return sum(file.stat().st_size for file in files) / 1e6


@pytest.fixture(scope="module")
def newcomer(wheel: Path) -> Iterator[Newcomer]:
    with TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        yield Newcomer(Path(folder), wheel)


def test_the_demo_reports_four_boats(
    newcomer: Newcomer, capsys: pytest.CaptureFixture[str]
) -> None:
    began = time.monotonic()
    said = newcomer.run(newcomer.flotilla, "demo")
    took_s = time.monotonic() - began
    with capsys.disabled():
        print(f"\nfirst demo of an installed wheel: {took_s:.1f} s (wanted: {FIRST_BOATS_S:g})")
    assert "results: out/demo/report.html" in said
    report = (newcomer.folder / "out/demo/report.html").read_text(encoding="utf-8")
    assert "Chart.js v" in report
    summary = json.loads((newcomer.folder / "out/demo/summary.json").read_text())
    assert [boat["id"] for boat in summary["boats"]] == [1, 2, 3, 4]


def test_the_demo_opens_its_page_in_the_browser(newcomer: Newcomer, tmp_path: Path) -> None:
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/shown\n')
    browser.chmod(0o755)
    keyboard, terminal = pty.openpty()
    try:
        subprocess.run(
            [newcomer.flotilla, "demo", "--set=duration_s=1", f"--out={tmp_path / 'out'}"],
            cwd=newcomer.folder,
            env={"PATH": os.environ["PATH"], "BROWSER": str(browser)},
            stdin=terminal,
            stdout=subprocess.DEVNULL,
            check=True,
            timeout=60,
        )
    finally:
        os.close(keyboard)
        os.close(terminal)
    assert (tmp_path / "shown").read_text().strip() == (tmp_path / "out/report.html").as_uri()


def test_a_run_has_the_digest_of_the_clones(newcomer: Newcomer, tmp_path: Path) -> None:
    newcomer.run(newcomer.flotilla, "run", "diamond", "--out", "out/diamond")
    here = [sys.executable, "-m", "sil", "run", "diamond", "--out", str(tmp_path)]
    subprocess.run(here, cwd=SOURCES, check=True, stdout=subprocess.DEVNULL)
    theirs, ours = (
        json.loads((folder / "summary.json").read_text())["digest"]
        for folder in (newcomer.folder / "out/diamond", tmp_path)
    )
    assert theirs == ours and len(ours) == 64


def test_the_wheel_adds_only_its_own_names_to_site_packages(
    newcomer: Newcomer, wheel: Path
) -> None:
    names = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    module = {name for name in names if re.fullmatch(r"flotilla\.(cpython-\d+-\S+|abi3)\.so", name)}
    assert len(module) == 1
    assert names - module == TOP_LEVEL | {"flotilla_usv-0.1.dist-info"}
    find = "from importlib.util import find_spec; print(list(map(find_spec, ('sil', 'tools'))))"
    assert newcomer.asks(find) == "[None, None]"
    assert newcomer.asks("import flotilla_usv, sil.wire; print(sil.__file__)").endswith(
        "flotilla_usv/tree/sil/__init__.py"
    )
    assert newcomer.asks("import flotilla; print(flotilla.Boat.__name__)") == "Boat"


def test_flotillad_of_the_wheel_has_the_version_of_this_commit(newcomer: Newcomer) -> None:
    program = newcomer.asks(
        "import flotilla_usv; from sil.live.live_world import build; print(build(print))"
    )
    version = newcomer.asks("import flotilla; print(flotilla.__version__)")
    revision = run(["git", "-C", str(SOURCES), "rev-parse", "--short=8", "HEAD"]).strip()
    said = newcomer.run(*ordinary_user(), program, "--version").strip()
    assert said == f"flotillad {version} ({revision})"


@pytest.mark.nightly
def test_boats_sail_live_from_the_wheel(newcomer: Newcomer) -> None:
    with live_buses() as bus:
        words = (newcomer.flotilla, "live", "diamond", "--bus", bus, "--duration=5")
        newcomer.run(*words, "--out=out/live")
    assert (newcomer.folder / "out/live/boat4/flotillad.log").exists()


@pytest.mark.nightly
def test_a_campaign_runs_from_the_wheel(newcomer: Newcomer) -> None:
    words = ["--constraint", newcomer.folder / "pins", "flotilla-usv[campaign]"]
    newcomer.run(newcomer.python, "-m", "pip", "install", "--quiet", *words)
    newcomer.run(
        *(newcomer.flotilla, "campaign", "diamond", "--runs=4", "--workers=2"),
        *("--set=duration_s=2", "--out=out/campaign"),
    )
    assert (newcomer.folder / "out/campaign/report.html").exists()


def test_the_list_names_required_packages_and_linked_libraries(wheel: Path) -> None:
    listed = parts(wheel)
    assert {"numpy", "nanobind", "libjs-chart.js", "libstdc++.so.6"} <= set(listed)
    assert any(name.startswith("libgcc-") for name in listed)
    assert "NOASSERTION" not in listed.values()


def test_the_core_installation_is_under_its_limit(
    newcomer: Newcomer, wheel: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wheel_mb = wheel.stat().st_size / 1e6
    with capsys.disabled():
        print(f"\ncore: {newcomer.core_mb:.0f} MB (limit {CORE_MB}), wheel {wheel_mb:.1f} MB")
    assert 50 < newcomer.core_mb < CORE_MB
