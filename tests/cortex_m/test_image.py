# SPDX-License-Identifier: MIT
"""A fixed-point boat on an emulated Cortex-M4, and nightly on arm64, beside the same boat here."""

import re
import shutil
import subprocess
from pathlib import Path
from statistics import fmean, median

import pytest

from sil.examine.metal.__main__ import BENCH, steady_stream
from sil.examine.metal.image import IMAGE, QEMU, QEMU_ARM64, play, play_arm64
from sil.examine.metal.size import sizes
from sil.examine.metal.stream import stream_of
from sil.lockstep.recording import Recording
from sil.lockstep.world import sail
from sil.scenario import scenario
from tests import measurements

ROOT = Path(__file__).resolve().parents[2]
TOOLS = (QEMU, "arm-none-eabi-g++")
HEAP = {"malloc", "_malloc_r", "_sbrk", "_Znwj", "_Znaj"}

pytestmark = pytest.mark.skipif(
    not all(map(shutil.which, TOOLS)), reason="no tools for Cortex-M: tools/metal"
)


def run(*command: str | Path) -> str:
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module", autouse=True)
def built() -> None:
    run(ROOT / "tools" / "build", "cortex-m")


@pytest.fixture(scope="module")
def arm64() -> None:
    if not all(map(shutil.which, (QEMU_ARM64, "aarch64-linux-gnu-g++"))):
        pytest.skip("no tools for arm64: tools/metal")
    run(ROOT / "tools" / "build", "player-arm64")


def sailed(scalar: str, path: Path) -> Recording:
    settings = ["duration_s=4.0", f"scalar='{scalar}'"]
    sail([scenario.load("diamond", settings)], {}, record=path)
    return Recording(path)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return sailed("q16", tmp_path_factory.mktemp("q16") / "recording.bin")


@pytest.mark.parametrize("boat", [0, 2])
def test_the_microcontroller_sends_the_same_bytes(recording: Recording, boat: int) -> None:
    stream, here = stream_of(recording, boat, 4.0)
    said = play(stream)
    assert int(said["ticks"]) == 401 and int(said["ticks_driving"]) > 90
    assert said["digest"] == here


@pytest.mark.nightly
@pytest.mark.usefixtures("arm64")
@pytest.mark.parametrize("boat", [0, 2])
def test_64_bit_arm_sends_the_same_bytes(recording: Recording, boat: int) -> None:
    stream, here = stream_of(recording, boat, 4.0)
    assert play_arm64(stream)["digest"] == here


@pytest.mark.nightly
@pytest.mark.usefixtures("arm64")
def test_a_floating_point_boat_has_another_digest(tmp_path: Path) -> None:
    stream, here = stream_of(sailed("float", tmp_path / "recording.bin"), 0, 4.0)
    assert play_arm64(stream)["digest"] != here


def test_the_digest_changes_when_every_message_is_damaged(recording: Recording) -> None:
    stream, here = stream_of(recording, 0, 1.0)
    first = 12 + int.from_bytes(stream[10:12], "little")
    deaf = stream[:first] + stream[first:].replace(b"\xfd", b"\xfc")
    assert play(stream)["digest"] == here != play(deaf)["digest"]


def test_a_stream_that_begins_with_no_boat_is_refused(recording: Recording) -> None:
    stream, _ = stream_of(recording, 0, 1.0)
    first = 12 + int.from_bytes(stream[10:12], "little")
    with pytest.raises(RuntimeError, match="the stream is damaged"):
        play(stream[first:])


def test_flash_and_ram_are_a_small_microcontrollers_and_nothing_is_left_out(
    recording: Recording,
) -> None:
    flash, ram = sizes(IMAGE.with_suffix(".map"))
    text, data, bss = map(int, run("arm-none-eabi-size", IMAGE).splitlines()[1].split()[:3])
    assert flash.total() == pytest.approx(text + data, rel=0.005)
    assert ram.total() == pytest.approx(data + bss, rel=0.005)
    assert flash.total() < 200_000
    stack = int(play(stream_of(recording, 0, 4.0)[0])["stack_bytes"])
    assert stack > 1000 and ram.total() + stack < 48_000


def test_its_instructions_flash_and_ram_are_those_of_the_page(recording: Recording) -> None:
    run(ROOT / "tools" / "build", "release", BENCH.name)
    each = [int(tick) for tick in play(steady_stream(1000))["instructions_driving"].split()]
    flash, ram = sizes(IMAGE.with_suffix(".map"))
    stack = int(play(stream_of(recording, 0, 4.0)[0])["stack_bytes"])
    now = {
        "instructions of a tick": [median(each), fmean(each)],
        "flash, RAM with stack": [flash.total() / 1000, (ram.total() + stack) / 1000],
    }
    for name, figures in now.items():
        noted = measurements.numbers(measurements.row(name)[0])
        assert figures == pytest.approx(noted, rel=0.02), f"{name}: {figures} now: tools/metal"


def symbols() -> set[str]:
    return {line.split()[-1] for line in run("arm-none-eabi-nm", IMAGE).splitlines()}


def test_there_is_no_heap_in_the_image() -> None:
    assert "reset" in symbols()
    assert not symbols() & HEAP


def test_there_is_nothing_of_the_mathematical_library_in_the_image() -> None:
    library = run("arm-none-eabi-g++", "-mcpu=cortex-m4", "-mthumb", "-print-file-name=libm.a")
    listed = run("arm-none-eabi-nm", "--defined-only", library.strip())
    functions = set(re.findall(r" [TW] (\w+)$", listed, re.MULTILINE))
    assert {"sin", "sqrtf", "floor"} <= functions
    assert not symbols() & functions


def test_there_are_no_floating_point_instructions_in_the_image() -> None:
    code = run("arm-none-eabi-objdump", "-d", IMAGE)
    assert re.search(r"\tsmull\t", code)
    assert not re.search(r"\tv(add|sub|mul|div|ldr|mov|cvt)\S*\t", code)


def test_only_sums_of_the_law_set_the_flag_of_saturation() -> None:
    code = run("arm-none-eabi-objdump", "-d", IMAGE)
    assert re.search(r"\tqadd\t", code)
    # smlabb, of a few sums of indices, sets it too, if one exceeds 32 bits.
    assert not re.search(r"\t([su]sat|qd(add|sub)|smla[dw]|smlsd|smuad)\S*\t", code)
