# SPDX-License-Identifier: MIT
"""The container's image in a Docker engine, of Debian, by the lines of BLUEOS.md."""

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.package.container import START
from tests.package.root import NETWORK, SOURCES, as_root, need, run
from tests.package.test_image import settings

PATIENCE_S = 60.0

pytestmark = pytest.mark.nightly


class Engine:
    """An engine of its own, with a network of its own that has loopback only."""

    def __init__(self, folder: Path) -> None:
        need("dockerd", "docker", "unshare", "nsenter", "ip")
        self.socket = folder / "socket"
        self.log = (folder / "log").open("wb")
        engine = [
            *("dockerd", f"--host=unix://{self.socket}", f"--data-root={folder / 'data'}"),
            *(f"--exec-root={folder / 'exec'}", f"--pidfile={folder / 'pid'}"),
            *("--storage-driver=vfs", "--bridge=none", "--iptables=false", "--ip6tables=false"),
        ]
        network = f'{NETWORK} && exec "$@"'
        self._process = subprocess.Popen(
            [*as_root(), "unshare", "--net", "bash", "-c", network, "network", *engine],
            stdin=subprocess.DEVNULL,
            stdout=self.log,
            stderr=self.log,
        )
        until(lambda: "Server:" in self.says("version", check=False))
        self.pid = int((folder / "pid").read_text())

    def says(self, *words: str, check: bool = True) -> str:
        """Run docker with these words, as a user would; what it prints."""
        return run([*as_root(), "docker", f"--host=unix://{self.socket}", *words], check)

    def beside(self, *words: str) -> list[str]:
        """The command line of a command in the engine's network."""
        return [*as_root(), "nsenter", f"--target={self.pid}", "--net", *words]

    def close(self) -> None:
        for container in self.says("ps", "--all", "--quiet").split():
            self.says("rm", "--force", container)
        self._process.terminate()
        self._process.wait(PATIENCE_S)
        # what an engine leaves mounted, and pytest could not remove
        run([*as_root(), "umount", str(self.socket.parent / "exec/netns/default")], check=False)
        self.log.close()


def until(happened: Callable[[], bool]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not happened():
        assert time.monotonic() < end_s
        time.sleep(0.3)


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    one = Engine(tmp_path_factory.mktemp("docker"))
    yield one
    one.close()


@pytest.fixture(scope="module")
def name(engine: Engine, image: Path) -> str:
    """The name that `docker load` prints."""
    (told,) = re.findall(r"Loaded image: (\S+)", engine.says("load", f"--input={image}"))
    assert told == f"flotilla:{settings(image)['Labels']['version']}"
    return str(told)


def test_a_boat_has_thrust_in_a_container_of_docker(
    engine: Engine, name: str, tmp_path: Path
) -> None:
    module = [sys.executable, "-m", "tests.package"]
    container = f"{module[-1]}.docker_run", str(engine.socket), name
    sail = f"{module[-1]}.sail", str(tmp_path), START, str(tmp_path / "state")
    words = [*module[:-1], *sail, *module[:-1], *container]
    said = run(engine.beside("env", f"--chdir={SOURCES}", *words))
    assert "pushes: (" in said and "status 0" in said


def test_a_container_is_restarted_when_flotillad_ends_and_its_folders_outlive_it(
    engine: Engine, name: str, tmp_path: Path
) -> None:
    folders = ("config:/etc", "state:/var/lib", "log:/var/log")
    volumes = [f"--volume={tmp_path}/{folder}/flotilla" for folder in folders]
    options = ["--detach", "--name=flotilla", "--network=host", "--restart=unless-stopped"]
    engine.says("run", *options, *volumes, name, "--can=mcast:0")

    def ready() -> int:
        return engine.says("logs", "flotilla").count("flotillad: ready")

    until(lambda: ready() == 1)
    page = run(engine.beside("curl", "--silent", "--fail", "http://127.0.0.1:9851/"))
    assert "<title>Flotilla</title>" in page
    check = ("/usr/bin/flotillad", "--config=/etc/flotilla/boat.toml", "--check")
    said = engine.says("exec", "--user=flotilla", "flotilla", *check)
    assert "the configuration is valid" in said
    engine.says("exec", "flotilla", "busybox", "killall", "-9", "flotillad")
    until(lambda: ready() == 2)
    engine.says("stop", "flotilla")
    assert engine.says("inspect", "--format={{.State.ExitCode}}", "flotilla") == "0\n"
    engine.says("rm", "flotilla")
    config = run(
        [*as_root(), "sed", 's/^can = .*/can = "mcast:1"/', f"{tmp_path}/config/boat.toml"]
    )
    run([*as_root(), "sh", "-c", 'printf %s "$1" > "$0"', f"{tmp_path}/config/boat.toml", config])
    engine.says("run", *options, *volumes, name)  # an update
    until(lambda: "ready: boat 1 on mcast:1" in engine.says("logs", "flotilla"))
    engine.says("rm", "--force", "flotilla")


def test_a_boat_sails_without_the_page_where_its_port_is_taken(engine: Engine, name: str) -> None:
    options = ["--detach", "--network=host"]
    for bus in (2, 3):
        engine.says("run", *options, f"--name=boat{bus}", name, f"--can=mcast:{bus}")
        until(lambda bus=bus: f"on mcast:{bus}" in engine.says("logs", f"boat{bus}"))
    assert "no page: another program has port 9851" in engine.says("logs", "boat3")
