# SPDX-License-Identifier: MIT
"""flotillad's configuration: the shipped file, error messages, help and version."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from sil.live.ordinary_user import ordinary_user
from tests.flotillad import FLOTILLAD, needs_flotillad
from tests.linux.process import LOOPBACK, ROOT, RealSea

SHIPPED = ROOT / "firmware" / "linux" / "boat.toml"
LINK = f"udpout:{LOOPBACK}:14550"


def run(*options: object) -> subprocess.CompletedProcess[str]:
    needs_flotillad()
    return subprocess.run(
        [*ordinary_user(), FLOTILLAD, *map(str, options)],
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )


def mistake(*options: object) -> str:
    """The only line that flotillad prints about a mistake."""
    done = run(*options)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("flotillad: ") and done.stderr.endswith("\n")
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_the_shipped_configuration_sails_with_a_few_words_from_the_command_line(
    sea: RealSea,
) -> None:
    sea.start(f"--config={SHIPPED}", "--log=", "--priority=0", "--lock-memory=false")
    sea.enter_formation()
    assert sea.process.words.splitlines() == [f"flotillad: ready: boat 2 on mcast:{sea.bus}"]


def test_the_keys_of_a_file_are_the_options(sea: RealSea, tmp_path: Path) -> None:
    config = tmp_path / "boat.toml"
    config.write_text(f"""
        can = "mcast:{sea.bus}"
        mavlink = ["{sea.ends[0].option}"]
        log = "{tmp_path / "elsewhere"}"
        stats = "{tmp_path / "stats.json"}"
        [param]
        CAN_NODE = 33
        MAV_SYSID = 7
    """)
    sea.start(f"--config={config}", f"--log={tmp_path / 'here'}", param={"MAV_SYSID": 9})
    sea.until(sea.ready)
    assert sea.source_node() == 33
    assert {m.get_srcSystem() for m in sea.messages[0]} == {9}
    assert sea.end() == 0
    assert list((tmp_path / "here").iterdir())
    assert not (tmp_path / "elsewhere").exists()
    assert (tmp_path / "stats.json").exists()


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ('cna = "mcast:5"', '1:1: unknown key "cna"'),
        ('can = "can0"', 'can: "can0" is not a CAN bus'),
        ('mavlink = ["tcp:127.0.0.1:5760"]', '"tcp:127.0.0.1:5760" is not a MAVLink link'),
        ("[param]\nLAW_MAGIC = 7", 'unknown parameter "LAW_MAGIC"'),
        ("[param]\nCTL_RATE = 10", "CTL_RATE = 10"),
        ("priority = 100", "priority: allowed"),
        ("can = ", "boat.toml:1:"),
    ],
)
def test_a_mistake_in_the_file_is_reported_in_one_line(
    tmp_path: Path, content: str, named: str
) -> None:
    file = tmp_path / "boat.toml"
    file.write_text(content + "\n")
    line = mistake("--config", file, f"--mavlink={LINK}")
    assert str(file) in line and named in line


@pytest.mark.parametrize(
    ("option", "named"),
    [
        ("--cna=mcast:5", "--cna=mcast:5"),
        ("--can=can0", '--can: "can0"'),
        ("--can=mcast:77", 'CAN bus "mcast:77"'),
        ("--mavlink=tcp:127.0.0.1:5760", '--mavlink: "tcp:127.0.0.1:5760"'),
        ("--mavlink=udpin:localhost:14550", '"localhost" is not a numeric IPv4 address'),
        ("--mavlink=udpout:127.0.0.1:99999", '"99999" is not a number from 1 to 65535'),
        ("--mavlink=udpout:127.0.0.1", "udpout:127.0.0.1"),
        ("--mavlink=udpout:127.0.0.1:14550,rate=fast", '",rate=fast"'),
        ("--mavlink=serial:/dev/ttyUSB0:57601", "57601"),
        ("--param=LAW_MAGIC=7", 'unknown parameter "LAW_MAGIC"'),
        ("--param=CTL_RATE=10", "CTL_RATE = 10"),
        ("--param=CTL_RATE", '"CTL_RATE" is not NAME=VALUE'),
        ("--param=ESC_STBD=0", "ESC_PORT"),
        ("--config=/nowhere.toml", "/nowhere.toml: cannot be read"),
    ],
)
def test_a_mistake_on_the_command_line_is_reported_in_one_line(
    tmp_path: Path, option: str, named: str
) -> None:
    given = {"--can": "mcast:5", "--mavlink": LINK, "--state-dir": tmp_path / "state"}
    name, _, value = option.partition("=")
    line = mistake(*(f"{key}={each}" for key, each in (given | {name: value}).items()))
    assert named in line


def test_an_option_given_twice_is_a_mistake() -> None:
    assert "--can" in mistake("--can=mcast:5", "--can=mcast:6", f"--mavlink={LINK}")


def test_a_boat_without_any_link_is_a_mistake(tmp_path: Path) -> None:
    assert "no MAVLink link" in mistake("--can=mcast:5", f"--state-dir={tmp_path}")


def test_flotillad_refuses_to_run_as_root(tmp_path: Path) -> None:
    needs_flotillad()
    if os.geteuid() != 0:
        pytest.skip("only root can try")
    done = subprocess.run(
        [FLOTILLAD, "--can=mcast:5", f"--mavlink={LINK}", f"--state-dir={tmp_path / 'state'}"],
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("flotillad: does not run as root: ")
    assert not (tmp_path / "state").exists()


def test_help_names_every_option_and_every_kind_of_address() -> None:
    done = run("--help")
    assert (done.returncode, done.stderr) == (0, "")
    options = "config can mavlink param state-dir log stats priority lock-memory version"
    for option in options.split():
        assert f"--{option}" in done.stdout
    for address in ("socketcan:", "mcast:", "udpin:", "udpout:", "udpbcast:", "serial:", "rate="):
        assert address in done.stdout


def test_version_is_one_line() -> None:
    done = run("--version")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(r"flotillad 0\.1 \([0-9a-f]{8}\)\n", done.stdout)


def test_a_file_is_checked_without_sailing(tmp_path: Path) -> None:
    done = run(f"--config={SHIPPED}", "--check")
    assert (done.returncode, done.stdout) == (0, "the configuration is valid\n")
    wrong = tmp_path / "boat.toml"
    wrong.write_text(f'mavlink = ["{LINK}"]\nstate = "/tmp"\n')
    assert f'{wrong}:2:1: unknown key "state"' in mistake(f"--config={wrong}", "--check")
