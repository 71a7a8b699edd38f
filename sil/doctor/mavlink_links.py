# SPDX-License-Identifier: MIT
"""The boat's MAVLink links: opened and listened to; `link_judge` judges what is heard.

While flotillad runs, it owns the links; then the doctor sends its requests to flotillad.
"""

import errno
from collections.abc import Iterator

from sil.doctor.boat_file import Boat, Link
from sil.doctor.computer import READ, WRITE, Computer
from sil.doctor.finding import Finding, bad, doubt, ok
from sil.doctor.heard import Post, listen
from sil.doctor.link_judge import judge_links, judge_senders, latency
from sil.view import alarm
from sil.view.states import held_by, keep_from_arming
from sil.wire.heartbeat import state_of


def links(computer: Computer, boat: Boat, seconds: float) -> Iterator[Finding]:
    """Open all links that can be opened, listen, and judge."""
    running = is_running(computer)
    door = _Door(computer)
    try:
        for link in boat.links:
            yield from door.open(link, running=running)
        key = _key(computer, boat)
        if door.held:
            yield from _ask(boat, door.held[0], seconds, key)
        elif running:
            remedy = 'add "udpin:127.0.0.1:14550,signing=off" to mavlink in the configuration file'
            yield doubt("flotillad", "runs, but none of its links accepts requests", remedy)
        elif door.posts:
            listen(door.posts, seconds, key)
            heard = [(post.link, post.heard) for post in door.posts]
            yield from judge_links(boat, heard)
            if not door.deaf:
                yield from judge_senders(boat, heard, seconds)
    finally:
        for post in door.posts:
            post.close()


class _Door:
    """Opens links.

    `posts`: open links. `held`: links that another program owns. `deaf`: a link needs more rights.
    """

    def __init__(self, computer: Computer) -> None:
        self._computer = computer
        self.posts: list[Post] = []
        self.held: list[Link] = []
        self.deaf = False

    def open(self, link: Link, *, running: bool) -> Iterator[Finding]:
        """Open a link, or report why it fails; leaves alone a serial line that flotillad uses."""
        if link.scheme == "udpbcast":
            return  # it only sends
        if link.scheme == "serial":
            trouble = _line_trouble(self._computer, link)
            if trouble is not None:
                yield trouble
            if trouble is not None or running:
                return
        try:
            device = self._computer.at(link.rest.rpartition(":")[0])
            self.posts.append(Post(link, device))
        except (OSError, ValueError) as error:
            yield from self._refused(link, error)

    def _refused(self, link: Link, error: OSError | ValueError) -> Iterator[Finding]:
        if isinstance(error, PermissionError):
            self.deaf = True
            yield doubt(link.address, "permission to listen denied", "start the doctor with sudo")
        elif isinstance(error, ValueError):
            yield bad(link.address, str(error), "correct it in the configuration file")
        elif error.errno == errno.EADDRINUSE:
            self.held.append(link)
        else:
            yield bad(link.address, "cannot be opened", alarm.of_error(error))


def is_running(computer: Computer) -> bool:
    """Whether a flotillad runs on that computer."""
    return any(
        computer.read(path.relative_to(computer.root)) == "flotillad"
        for path in computer.at("/proc").glob("[0-9]*/comm")
    )


def _line_trouble(computer: Computer, link: Link) -> Finding | None:
    device = link.rest.rpartition(":")[0]
    try:
        if computer.may(device, READ | WRITE):
            return None
    except OSError:
        remedy = "check its cable; `ls /dev/serial/by-id /dev/tty*` lists the existing devices"
        return bad(link.address, "there is no such device", remedy)
    user = computer.user
    remedy = f"sudo usermod -aG dialout {user} && sudo systemctl restart flotillad"
    return bad(link.address, f"{user} may not use the device", remedy)


def _key(computer: Computer, boat: Boat) -> bytes | None:
    """The signing key, None if there is none or it is unreadable."""
    if not boat.signing_key:
        return None
    try:
        data = computer.at(boat.signing_key).read_bytes()
        return data if len(data) == 32 else bytes.fromhex(data.decode().strip())
    except (OSError, ValueError):
        return None


def _ask(boat: Boat, link: Link, seconds: float, key: bytes | None) -> Iterator[Finding]:
    """Send requests to the flotillad that owns the links."""
    post, listen_s = Post(link, ask=True), max(seconds, 2.5)
    try:
        listen([post], listen_s, key if link.signing != "off" else None)
    finally:
        post.close()
    heard = post.heard
    beat = heard.last.get((boat.system, "HEARTBEAT"))
    if beat is None:
        remedy = (
            "`sudo ss -ulnp` names the program; `journalctl -u flotillad` shows the boat's messages"
        )
        if link.signing == "required" and key is None:
            remedy = "start the doctor with sudo: it must read the signing key"
        what = f"a program has this port, but no boat {boat.system} answers there"
        yield bad(link.address, what, remedy)
        return
    state = state_of(beat.custom_mode, beat.base_mode, beat.system_status) or "unknown"
    yield ok(link.address, f"flotillad answers: {state}")
    for sender in heard.round_trips_s:
        if sender[0] == boat.system:
            yield latency(link.address, "flotillad", heard.latency_s(sender) or 0.0)
    low, high = (heard.last.get((boat.system, name)) for name in ("COND", "COND2"))
    if low is None or high is None:
        what = f"its conditions are not heard in {listen_s:g} s"
        yield doubt("boat", what, "listen longer: --seconds 20")
        return
    bits = int(low) | int(high) << 24
    serious = keep_from_arming(bits)
    for complaint in held_by(bits, state):
        level = bad if complaint in serious else doubt
        yield level("boat", complaint, "firmware/docs/SUPERVISOR.md explains each condition")
