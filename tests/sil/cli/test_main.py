# SPDX-License-Identifier: MIT
"""The command line: usage errors are reported in one line and change nothing."""

import errno
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

from sil import cli
from sil.cli.main import main, sentence
from sil.scenario import presets
from tests.sil.mistakes import assert_told_in_one_line

COMMANDS = Path(cli.__file__).parent.glob("*_command.py")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["run", "dimond"],
            'unknown scenario "dimond"; did you mean "diamond"?',
        ),
        (["campain", "diamond"], 'unknown command "campain"; did you mean "campaign"?'),
        (["run", "diamond", "--set", "hull=oter"], 'unknown hull "oter"; did you mean "otter"?'),
        (["run", "nowhere.toml"], "nowhere.toml: No such file"),
        (["run", "diamond", "--set", "link.dely_s=1"], 'did you mean "delay_s"?'),
        (["run", "diamond", "--set", "duration_s=-1"], "greater than 0"),
        (["run", "diamond", "--set", "duration_s=1e300"], "less than or equal to 1000000"),
        (["run", "diamond", "--set", "vessel.m23=1e300"], "its square must be less than m22 × m33"),
        (["run", "diamond", "--set", "waves.height_m=1e300"], "less than or equal to 100"),
        (["run", "diamond", "--set", "clocks.offset_s=1e15"], "less than or equal to 1000000000"),
        (["run", "diamond", "--set", 'name="../diamond"'], "must be one folder's name"),
        (["run", "diamond", "--set", 'name=""'], "must be one folder's name"),
        (["run", "diamond", "--set", "navigation.rate_hz=400"], "must be at most rate_hz = 100"),
        (["run", "diamond", "--seed", "-1"], "greater than or equal to 0"),
        (["run", "diamond", "--param", "LAW_KX"], "must be NAME=VALUE"),
        (["run", "diamond", "--param", "LAW_KX=9"], "LAW_KX = 9.0 is out of range"),
        (["run", "diamond", "--param", "LAW_KZ=1"], 'unknown parameter LAW_KZ; did you mean "'),
        (["run", "diamond", "--param", "LAW_K=1"], 'unknown parameter LAW_K; did you mean "'),
    ],
)
def test_a_mistake_is_reported_in_one_line(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main([*arguments, "--out", str(out)]) == 2
    assert_told_in_one_line(said, capsys)
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "diamond", "--out", ""], "argument --out: it is empty; name a folder"),
        (["view", "out", "--length", "nan"], "argument --length: nan is not a length in metres"),
        (["doctor", "--seconds", "0"], "argument --seconds: 0 is not a number of seconds"),
        (["campaign", "diamond", "--runs", "1e9"], "argument --runs: 1e9 is not a whole number"),
        (["campaign", "diamond", "--run", "-1"], "argument --run: -1 is not a whole number of"),
    ],
)
def test_a_value_that_an_option_does_not_take_is_told_in_plain_words(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2 and said in capsys.readouterr().err


def test_a_card_that_is_not_there_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", "--root", str(tmp_path / "card")]) == 2
    assert_told_in_one_line("card: there is no such folder", capsys)


def test_a_run_that_needs_more_memory_than_there_is_is_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def load(*_: object) -> None:
        raise MemoryError("Unable to allocate 112. GiB")

    monkeypatch.setattr("sil.scenario.scenario.load", load)
    assert main(["run", "diamond", "--out", str(tmp_path)]) == 2
    assert_told_in_one_line("not enough memory: Unable to allocate 112. GiB; sail", capsys)


def test_an_unwritable_results_folder_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    assert main(["run", "turning", "--out", str(tmp_path / "file")]) == 2
    assert "file" in capsys.readouterr().err


def test_a_run_in_which_boats_come_too_near_ends_with_status_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = ["--set", "duration_s=10", "--out", str(tmp_path)]
    assert main(["run", "diamond_frame1", *short]) == 1
    assert "two boats came nearer than a hull's length" in capsys.readouterr().out


def test_version_is_that_of_the_python_package(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"flotilla {metadata.version('flotilla-usv')}\n"


def test_help_lists_every_command_and_imports_none_of_them() -> None:
    program = "import sys; from sil.cli.main import main; main(['--help']); print(*sys.modules)"
    *lines, modules = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    for verb in ("run", "live", "demo", "campaign", "compare", "certify", "results", "fuzz"):
        assert any(line.split()[:1] == [verb] for line in lines)
    assert not {"numpy", "flotilla", "matplotlib", "rich"} & set(modules.split())


@pytest.mark.parametrize("verb", sorted(path.stem.partition("_")[0] for path in COMMANDS))
def test_help_of_a_command_has_examples_and_is_quick(verb: str) -> None:
    program = (
        f"import sys; from sil.cli.main import main\n"
        f"try: main(['{verb}', '--help'])\n"
        f"finally: print(*sys.modules)"
    )
    *lines, modules = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    assert f"usage: flotilla {verb}" in lines[0]
    examples = lines[lines.index("examples:") + 1 :]
    assert any(f"flotilla {verb}" in line or f"tools/{verb}" in line for line in examples)
    assert not {"numpy", "flotilla", "matplotlib", "rich"} & set(modules.split())


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(errno.EAFNOSUPPORT, "Address family not supported"), "tools/with-vcan"),
        (OSError(errno.ENODEV, "No such device"), "no such CAN interface"),
        (FileNotFoundError(errno.ENOENT, "No such file", "a.toml"), "a.toml: No such file"),
        (ValueError("as it is"), "as it is"),
    ],
)
def test_errors_are_sentences_without_numbers(error: Exception, words: str) -> None:
    assert words in sentence(error) and "Errno" not in sentence(error)


def test_missing_extra_is_named_with_its_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "tornado", None)
    for module in [name for name in sys.modules if name.startswith(("tornado.", "sil.view.serve"))]:
        monkeypatch.delitem(sys.modules, module)
    assert main(["view", str(tmp_path)]) == 2
    assert (
        capsys.readouterr().err
        == "error: flotilla view needs tornado: pip install 'flotilla-usv[view]'\n"
    )


def test_run_without_matplotlib_has_a_report_without_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module in ("drawing", "one_run"):
        monkeypatch.setattr(f"sil.report.{module}.CAN_DRAW", False)
    assert main(["run", "turning", "--set", "duration_s=1", "--out", str(tmp_path)]) == 0
    assert "pip install 'flotilla-usv[view]'" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {
        "recording.bin",
        "report.html",
        "summary.json",
        "trace.npz",
    }


def test_hulls_are_listed_and_printed_as_their_files(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hulls"]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert listed == ["blueboat", "heron", "otter", "paper", "wamv"]
    for suffix in ("param", "params"):
        assert main(["hulls", "otter", "--format", suffix]) == 0
        file = presets.FOLDER / f"otter.{suffix}"
        assert capsys.readouterr().out == file.read_text(encoding="utf-8")
    assert main(["hulls", "wamw"]) == 2
    assert 'did you mean "wamv"?' in capsys.readouterr().err
