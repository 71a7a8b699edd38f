# SPDX-License-Identifier: MIT
"""python -m sil.bench.page_cost: measures the cost of a live view of many boats.

A line of boats sails in lockstep first. Its radio traffic is then replayed in real time to a server
as `tools/view` runs it, while a client reads every frame. The boats' SR_STATE is 10 Hz, every other
rate the firmware's default.
"""

import argparse
import asyncio
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import psutil
from tornado.websocket import websocket_connect

from sil.live.free_port import free_port
from sil.lockstep.world import sail
from sil.scenario import arguments, scenario
from sil.scenario.scenario import Scenario
from sil.wire.mavlink_mcast import LOOPBACK

_WARM_UP_S = 2.0
Said = list[tuple[float, bytes]]


class Cost(NamedTuple):
    """The server's share of a core, frames sent, and resident memory in bytes."""

    core: float
    frames_per_s: float
    frame_bytes: int
    memory: int


def fleet_of(boats: int) -> Scenario:
    """A line of that many boats, each behind the one before."""
    nominal = scenario.read("diamond", ["duration_s=10", 'law="product"', "parameters.SR_STATE=10"])
    first = nominal.document["boat"][0]
    nominal.document["boat"] = [
        {**first, "follows": i, "offset_m": [-2.0, 0.0], "eta": [-2.0 * i, 0.0, 0.0]}
        for i in range(boats)
    ]
    return scenario.check(nominal)


def said_by(fleet: Scenario) -> Said:
    """All radio traffic of a run: seconds since its release, and chunks."""
    said: Said = []

    def watch(batch: Any, _: Sequence[int], k: int, __: int) -> None:
        for agent in range(len(fleet.boat) + 1):
            if data := bytes(batch.fleet.sent(agent)):
                said.append((k / fleet.rate_hz, data))

    (run,) = sail([fleet], {}, watch=watch)
    if isinstance(run, Exception):
        raise run
    return said


async def _watch(url: str, frames: list[int]) -> None:
    """A client that reads every frame."""
    page = await websocket_connect(f"ws{url.removeprefix('http')}live")
    try:
        while (message := await page.read_message()) is not None:
            frames.append(len(message))
    finally:
        page.close()
        while await page.read_message() is not None:
            pass


async def _measured(url: str, server: int, seconds: float) -> Cost:
    frames: list[int] = []
    watching = asyncio.ensure_future(_watch(url, frames))
    process = psutil.Process(server)
    await asyncio.sleep(_WARM_UP_S)
    frames.clear()
    began, began_s = process.cpu_times(), time.monotonic()
    await asyncio.sleep(seconds)
    used, passed_s = process.cpu_times(), time.monotonic() - began_s
    watching.cancel()
    await asyncio.gather(watching, return_exceptions=True)
    busy_s = used.user + used.system - began.user - began.system
    return Cost(
        busy_s / passed_s, len(frames) / passed_s, max(frames, default=0), process.memory_info().rss
    )


def _say(said: Said, port: int, stop: threading.Event) -> None:
    """Send the traffic in real time, repeatedly, until `stop`."""
    began_s, turn_s = time.monotonic(), 0.0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        while True:
            for at_s, data in said:
                wait_s = began_s + turn_s + at_s - time.monotonic()
                if stop.wait(max(wait_s, 0.0)):
                    return
                end.sendto(data, (LOOPBACK, port))
            turn_s += said[-1][0]


@contextmanager
def viewed(said: Said) -> Iterator[tuple[str, int]]:
    """A server as `tools/view` runs it, which receives the traffic: page's address, process id."""
    port = free_port()
    command = ["-m", "sil", "view", f"udpin:{LOOPBACK}:{port}", "--bind", f"{LOOPBACK}:0"]
    server = subprocess.Popen(  # noqa: S603
        [sys.executable, *command], stdout=subprocess.PIPE, text=True
    )
    stop = threading.Event()
    sailing = threading.Thread(target=_say, args=(said, port, stop))
    sailing.start()
    try:
        assert server.stdout is not None
        yield server.stdout.readline().split()[-1], server.pid
    finally:
        stop.set()
        sailing.join()
        server.terminate()
        server.communicate()


def main(given: Sequence[str]) -> int:
    """Run the module's command line; exit status 0."""
    parser = argparse.ArgumentParser(prog="python -m sil.bench.page_cost", description=__doc__)
    parser.add_argument(
        "--boats", type=arguments.count, default=20, metavar="N", help="number of boats (20)"
    )
    parser.add_argument("--seconds", type=float, default=20.0, metavar="S", help="seconds (20)")
    options = parser.parse_args(given)
    said = said_by(fleet_of(options.boats))
    with viewed(said) as (url, server):
        cost = asyncio.run(_measured(url, server, options.seconds))
    span_s, total = said[-1][0], sum(len(data) for _, data in said)
    print(f"{options.boats} boats and their leader send {total / span_s / 1000:.1f} kB/s")
    print(f"the page is sent {cost.frames_per_s:.1f} frames a second of {cost.frame_bytes} bytes")
    print(f"the server takes {100.0 * cost.core:.1f} % of a core, {cost.memory / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
