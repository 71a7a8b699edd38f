# SPDX-License-Identifier: MIT
"""A boat on a Cortex-M4, emulated, against the same boat here."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from sil import scenario
from sil.metal.image import QEMU, play
from sil.metal.size import sizes
from sil.metal.stream import stream_of
from sil.recording import Recording
from sil.world import sail

ROOT = Path(__file__).resolve().parents[3]
COMPILER = "arm-none-eabi-g++"
HEAP = {"malloc", "_malloc_r", "_sbrk", "_Znwj", "_Znaj"}

pytestmark = pytest.mark.skipif(
    not (shutil.which(QEMU) and shutil.which(COMPILER)), reason="no tools for Cortex-M: tools/metal"
)


def run(*command: str | Path) -> str:
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module")
def image() -> Path:
    run("cmake", "--preset", "cortex-m", f"-DPython_EXECUTABLE={sys.executable}")
    run("cmake", "--build", "--preset", "cortex-m", "--target", "flotilla_player")
    return ROOT / "build/cortex-m/firmware/flotilla_player"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("diamond") / "recording.bin"
    sail([scenario.load("diamond", ["duration_s=4.0"])], {}, record=path)
    return Recording(path)


def test_until_its_mathematics_rounds_otherwise_it_says_what_the_boat_here_says(
    image: Path, recording: Recording
) -> None:
    stream, digest = stream_of(recording, 0, 4.0)
    said = play(image, stream)
    assert int(said["ticks"]) == 401 and int(said["ticks_driving"]) > 90
    assert said["digest"] == digest


def test_a_boat_to_which_no_message_comes_whole_says_something_else(
    image: Path, recording: Recording
) -> None:
    stream, digest = stream_of(recording, 0, 1.0)
    first = 12 + int.from_bytes(stream[10:12], "little")
    deaf = stream[:first] + stream[first:].replace(b"\xfd", b"\xfc")
    assert play(image, stream)["digest"] == digest != play(image, deaf)["digest"]


def test_a_stream_that_begins_with_no_boat_is_refused(image: Path, recording: Recording) -> None:
    stream, _ = stream_of(recording, 0, 1.0)
    first = 12 + int.from_bytes(stream[10:12], "little")
    with pytest.raises(RuntimeError, match="the stream is damaged"):
        play(image, stream[first:])


def test_flash_and_ram_are_a_small_microcontrollers_and_nothing_is_left_out(
    image: Path, recording: Recording
) -> None:
    flash, ram = sizes(image.with_suffix(".map"))
    text, data, bss = map(int, run("arm-none-eabi-size", image).splitlines()[1].split()[:3])
    assert flash.total() == pytest.approx(text + data, rel=0.005)
    assert ram.total() == pytest.approx(data + bss, rel=0.005)
    assert flash.total() < 160 * 1024
    stack = int(play(image, stream_of(recording, 0, 4.0)[0])["stack_bytes"])
    assert stack > 1000 and ram.total() + stack < 32 * 1024


def test_there_is_no_heap_in_it(image: Path) -> None:
    symbols = {line.split()[-1] for line in run("arm-none-eabi-nm", image).splitlines()}
    assert "reset" in symbols
    assert not symbols & HEAP
