# SPDX-License-Identifier: MIT
# ruff: noqa: E501 (a row is a fault)
"""Each planted fault is found, with what helps, and nothing else is blamed."""

import json
import os
import socket
import subprocess
import sys
import tarfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import flotilla
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.doctor import boat_file
from sil.doctor.boat_file import saved
from sil.doctor.checkup import examine, verdict
from sil.doctor.collection import collect
from sil.doctor.computer import Computer
from sil.doctor.finding import Level
from sil.doctor.machine_checks import machine
from sil.live.ordinary_user import ordinary_user
from tests.flotillad import FLOTILLAD
from tests.sil.doctor.patient import BUS, CONFIG, KEY, KEY_FILE, SYSTEM, Patient, Speaker
from tests.sil.full_disk import full_disk

PARAMETERS = "/var/lib/flotilla/parameters.txt"
SERVICE = "/etc/systemd/system/flotillad.service"
BAD, DOUBT = Level.BAD, Level.DOUBT


def rewrite(path: str, text: str | bytes) -> Callable[[Patient], None]:
    def plant(patient: Patient) -> None:
        patient.put(path, text)

    return plant


def remove(path: str) -> Callable[[Patient], None]:
    return lambda patient: patient.at(path).unlink()


def mode(path: str, bits: int) -> Callable[[Patient], None]:
    return lambda patient: patient.at(path).chmod(bits)


def configure(**changed: str) -> Callable[[Patient], None]:
    return lambda patient: patient.configure(**changed)


def masked(patient: Patient) -> None:
    patient.at(SERVICE).symlink_to("/dev/null")


def damaged(patient: Patient) -> None:
    file = patient.at(PARAMETERS)
    file.write_text(file.read_text().replace("LAW_KX = ", "LAW_KX = 1", 1))


def no_folder(patient: Patient) -> None:
    patient.at("/var/log/flotilla").rmdir()


def one_motor_controller(patient: Patient) -> None:
    del patient.escs[32], patient.health[32]


def silent_bus(patient: Patient) -> None:
    patient.escs.clear()
    patient.health.clear()


def same_index(patient: Patient) -> None:
    patient.escs[33] = 0


def same_node(patient: Patient) -> None:
    patient.uptimes[31] = [500, 20]


def sick(patient: Patient) -> None:
    patient.health[32] = 3


def commanded(patient: Patient) -> None:
    patient.commander = 10


def mute_unit(patient: Patient) -> None:
    patient.on_line.clear()


def unit_of_another_system(patient: Patient) -> None:
    patient.on_line[:] = [Speaker(SYSTEM + 5, 1, "LOCAL_POSITION_NED", "ATTITUDE")]


def slow_unit(patient: Patient) -> None:
    patient.unit.every = 8


def no_attitude(patient: Patient) -> None:
    patient.unit.names = ("LOCAL_POSITION_NED",)


def no_answers(patient: Patient) -> None:
    patient.unit.answers = False


def late_unit(patient: Patient) -> None:
    patient.unit.late_s = 0.25


def wrong_baud(patient: Patient) -> None:
    patient.noise = bytes(range(40))


def no_leader(patient: Patient) -> None:
    patient.leader.mavlink.srcSystem = 77


def namesake(patient: Patient) -> None:
    patient.on_radio.append(Speaker(SYSTEM, 1, "HEARTBEAT", "NAV_CONTROLLER_OUTPUT"))


def unsigned(patient: Patient) -> None:
    link = f"udpin:127.0.0.1:{patient.port}"
    patient.configure(mavlink=f'["serial:/dev/ttyNAV:115200,signing=off", "{link}"]')


def port_taken(patient: Patient) -> None:
    taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    taken.bind(("127.0.0.1", patient.port))
    patient.keep.append(taken)


def another_bit_rate(state: str, rate: int, restart_ms: int = 100) -> Callable[[Patient], None]:
    """A real interface, as `ip` tells of it: recorded from an MCP2515 under Linux 6.1."""
    told = [{"ifname": "can0", "flags": ["NOARP", "UP", "LOWER_UP"], "link_type": "can", "linkinfo": {
        "info_kind": "can", "info_data": {
            "state": state, "berr_counter": {"tx": 136, "rx": 0}, "restart_ms": restart_ms,
            "bittiming": {"bitrate": rate, "sample_point": "0.750", "tq": 125}, "clock": 8000000}}}]  # fmt: skip

    def plant(patient: Patient) -> None:
        interface(patient)
        program = patient.put("/bin/ip", f"#!/bin/sh\necho '{json.dumps(told)}'\n")
        program.chmod(0o755)

    return plant


def interface(patient: Patient, flags: str = "0x40081", kind: str = "280") -> None:
    patient.put("/sys/class/net/can0/flags", flags)
    patient.put("/sys/class/net/can0/type", kind)
    patient.configure(can='"socketcan:can0"')


#: Planted fault, and the finding: level, place, text, remedy.
FAULTS = {
    "no configuration": (remove(CONFIG), BAD, CONFIG, "no such configuration", "--config"),
    "a wrong key": (configure(kan='"x"'), BAD, f"{CONFIG}:", 'unknown key "kan"', "restart flotillad"),
    "a parameter out of range": (configure(param=f"{{ MAV_SYSID = {SYSTEM}, FS_NAV_S = 999 }}"), BAD, f"{CONFIG}:", "FS_NAV_S", "restart"),
    "nothing sets the clock": (remove("/run/systemd/timesync/synchronized"), DOUBT, "clock", "network", "set-ntp"),
    "little memory": (rewrite("/proc/meminfo", "MemAvailable: 40000 kB\n"), DOUBT, "memory", "40 MB", "ps aux"),
    "a slow processor": (rewrite("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n"), DOUBT, "processor", "lowest speed", "ondemand"),
    "a hot processor": (rewrite("/sys/class/thermal/thermal_zone0/temp", "84000\n"), DOUBT, "processor", "84 °C", "heat sink"),
    "low voltage": (rewrite("/sys/devices/platform/soc/soc:firmware/get_throttled", "50005\n"), BAD, "supply", "voltage", "5.1 V"),
    "no service": (remove("/lib/systemd/system/flotillad.service"), BAD, "flotillad.service", "not installed", "tools/flash"),
    "a service that does not start": (remove("/etc/systemd/system/multi-user.target.wants/flotillad.service"), BAD, "flotillad.service", "does not start", "systemctl enable"),
    "a masked service": (masked, BAD, "flotillad.service", "masked", "unmask"),
    "not in dialout": (rewrite("/etc/group", "dialout:x:20:\nflotilla:x:990:\n"), BAD, "user", "dialout", "usermod -aG dialout"),
    "no folder for logs": (no_folder, BAD, "/var/log/flotilla", "does not exist", "install -d -o flotilla"),
    "a state folder that is read only": (mode("/var/lib/flotilla", 0o555), BAD, "/var/lib/flotilla", "may not write", "install -d -o flotilla"),
    "parameters never saved": (remove(PARAMETERS), BAD, PARAMETERS, "never saved", "PREFLIGHT_STORAGE"),
    "damaged parameters": (damaged, BAD, PARAMETERS, "damaged", "PREFLIGHT_STORAGE"),
    "no signing key": (remove(KEY_FILE), BAD, KEY_FILE, "no such signing key", "/dev/urandom"),
    "a key that others read": (mode(KEY_FILE, 0o644), BAD, KEY_FILE, "others may read", "chmod 600"),
    "half a key": (rewrite(KEY_FILE, KEY[:16]), BAD, KEY_FILE, "16 bytes; a key has 32", "again, whole"),
    "no serial device": (remove("/dev/ttyNAV"), BAD, "serial:/dev/ttyNAV", "no such device", "by-id"),
    "an address of another computer": (configure(mavlink='["udpin:192.0.2.7:14550,signing=off"]'), BAD, "udpin:192.0.2.7:14550", "cannot be opened", "ip address"),
    "a port that another has": (port_taken, BAD, "udpin:127.0.0.1", "no boat 2 answers", "ss -ulnp"),
    "no CAN interface": (configure(can='"socketcan:can7"'), BAD, "socketcan:can7", "no such interface", "dtoverlay"),
    "an interface of Ethernet": (lambda p: interface(p, kind="1"), BAD, "socketcan:can0", "not a CAN interface", "type can"),
    "CAN is down": (lambda p: interface(p, "0x40080"), BAD, "socketcan:can0", "is down", "networkctl reload"),
    "another bit rate": (another_bit_rate("ERROR-ACTIVE", 500_000), BAD, "socketcan:can0", "500,000", "BitRate=1M"),
    "a bus with errors": (another_bit_rate("ERROR-PASSIVE", 1_000_000), BAD, "socketcan:can0", "ERROR-PASSIVE, 136 errors", "60 Ω"),
    "a bus that stays off": (another_bit_rate("ERROR-ACTIVE", 1_000_000, 0), DOUBT, "socketcan:can0", "stays off", "RestartSec"),
    "a silent bus": (silent_bus, BAD, f"mcast:{BUS}", "no motor controller is heard", "120 Ω"),
    "one motor controller": (one_motor_controller, BAD, f"mcast:{BUS}", "index 1 (ESC_STBD); heard: 0", "supply"),
    "one index twice": (same_index, BAD, f"mcast:{BUS}", "nodes 31, 33 both have the index 0", "index, not node id"),
    "one node id twice": (same_node, BAD, f"mcast:{BUS}", "share the id 31", "its own id"),
    "a sick motor controller": (sick, BAD, f"mcast:{BUS}", "node 32 reports health CRITICAL", "its own tool"),
    "two that command": (commanded, BAD, f"mcast:{BUS}", "node 10 commands", "one node may command"),
    "a mute navigation unit": (mute_unit, BAD, "navigation unit", "sends no position", "baud"),
    "a unit of another system": (unit_of_another_system, BAD, "navigation unit", "systems heard: 7, 100", "system id"),
    "a slow navigation unit": (slow_unit, DOUBT, "serial:/dev/ttyNAV", "positions per second", "10 Hz"),
    "no attitude": (no_attitude, BAD, "serial:/dev/ttyNAV", "no ATTITUDE", "ATTITUDE"),
    "a unit without clock": (no_answers, DOUBT, "serial:/dev/ttyNAV", "TIMESYNC", "NAV_LAG_S"),
    "a late navigation unit": (late_unit, DOUBT, "serial:/dev/ttyNAV", "ms", "faster link"),
    "a wrong baud rate": (wrong_baud, BAD, "serial:/dev/ttyNAV", "not MAVLink", "baud"),
    "no leader": (no_leader, DOUBT, "radio", "system 100 (FORM_LEADER)", "pairing"),
    "two boats of one name": (namesake, BAD, "udpin:127.0.0.1", "another boat has", "MAV_SYSID"),
    "unsigned where signed is required": (unsigned, BAD, "udpin:127.0.0.1", "does not sign", "signing=off"),
    "no key at all": (configure(signing_key=""), DOUBT, "signing", "no key", "signing-key"),
}  # fmt: skip
#: Further findings that a fault causes.
CONSEQUENCES = {
    "no serial device": ("sends no position",),
    "an address of another computer": ("sends no position", "FORM_LEADER"),
    "a mute navigation unit": ("nothing is heard",),
    "another bit rate": ("cannot be opened",),
    "a bus with errors": ("cannot be opened",),
    "a bus that stays off": ("cannot be opened",),
    "a wrong baud rate": ("positions per second", "TIMESYNC", "ATTITUDE", "sends no position"),
}


def test_a_healthy_boat_is_ready(patient: Patient) -> None:
    found = patient.examined()
    assert [f for f in found if f.level is not Level.OK and "simulated bus" not in f.what] == []
    assert verdict(found) == "ready, 1 to look at"


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found_with_its_remedy(
    patient: Patient, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant, level, where, what, remedy = FAULTS[fault]
    plant(patient)
    monkeypatch.setenv("PATH", f"{patient.at('/bin')}:{os.environ['PATH']}")
    complaints = patient.complaints()
    found = [f for f in complaints if f.where.startswith(where) and what in f.what]
    assert len(found) == 1, complaints
    assert found[0].level is level and remedy in found[0].remedy
    others = [f for f in complaints if f is not found[0]]
    follow = (*CONSEQUENCES.get(fault, ()), "ms to arrive")  # of a machine that is busy now
    assert [f for f in others if not any(word in f"{f.where} {f.what}" for word in follow)] == []


def test_at_least_twenty_faults_keep_a_boat_from_sailing() -> None:
    assert sum(level is BAD for _, level, *_ in FAULTS.values()) >= 20


def test_a_clock_of_1970_and_a_full_disk_are_found(tmp_path: Path) -> None:
    (clock,) = machine(Computer(tmp_path), [], now_s=3600.0)
    assert (clock.level, clock.where) == (BAD, "clock")
    assert "1970-01-01 01:00" in clock.what and "battery" in clock.remedy
    if os.geteuid() != 0:
        pytest.skip("SKIPPED: a small disk needs root")
    small = tmp_path / "var/log/flotilla"
    small.mkdir(parents=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(small)], check=True)
    try:
        full = [f for f in machine(Computer(tmp_path), ["/var/log/flotilla"]) if f.level is BAD]
    finally:
        subprocess.run(["umount", str(small)], check=True)
    assert [(f.where, f.what) for f in full] == [("/var/log/flotilla", "1 MB are free")]


def told(
    patient: Patient, *options: object, prefix: Sequence[str] = ()
) -> "subprocess.CompletedProcess[str]":
    words = [
        *prefix,
        sys.executable,
        "-m",
        "sil",
        "doctor",
        "--root",
        patient.root,
        "--seconds",
        "0.7",
    ]
    run = lambda: subprocess.run(  # noqa: E731
        [*map(str, words), *map(str, options)], capture_output=True, text=True, check=False
    )
    done: subprocess.CompletedProcess[str] = patient.while_speaking(run)
    return done


def test_the_verdict_comes_first_and_is_the_exit_status(patient: Patient) -> None:
    done = told(patient)
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, "ready, 1 to look at")
    silent_bus(patient)
    done = told(patient, "--json")
    report = json.loads(done.stdout)
    assert done.returncode == 1 and report["ready"] is False
    assert report["verdict"].startswith("not ready: one thing keeps this boat from sailing")
    assert [f["where"] for f in report["findings"] if f["level"] == "bad"] == [f"mcast:{BUS}"]
    assert all(f.keys() == {"level", "where", "what", "remedy"} for f in report["findings"])


def test_the_collection_has_logs_and_findings_and_no_key(patient: Patient) -> None:
    patient.put("/var/log/flotilla/mavlink0-00001.tlog", b"log")
    patient.put("/var/log/flotilla/copy.key", KEY.hex())
    patient.put("/var/lib/flotilla/notes.txt", b"the key is " + KEY)
    out = patient.root / "report.tar.gz"
    assert told(patient, "--collect", out).returncode == 0
    with tarfile.open(out) as archive:
        held = {
            member.name.removeprefix("flotilla-report/"): archive.extractfile(member).read()
            for member in archive.getmembers()
        }
    assert {"doctor.json", "etc/flotilla/boat.toml", "log/mavlink0-00001.tlog"} < set(held)
    assert {"state/parameters.txt", "commands/journal.txt", "commands/kernel_version.txt"} < set(
        held
    )
    assert json.loads(held["doctor.json"])["ready"] is True
    for data in held.values():
        assert KEY not in data and KEY.hex().encode() not in data.lower()


@pytest.mark.parametrize("broken", ["a full disk", "Ctrl-C"])
def test_a_collection_that_is_cut_short_leaves_no_file(
    patient: Patient, broken: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    patient.put("/var/log/flotilla/mavlink0-00001.tlog", os.urandom(100_000))
    out, computer = patient.root / "reports" / "report.tar.gz", Computer(patient.root)
    out.parent.mkdir()
    (boat, _) = boat_file.read(computer, CONFIG)
    if broken == "Ctrl-C":
        monkeypatch.setattr(tarfile.TarFile, "addfile", interrupted)
        with pytest.raises(KeyboardInterrupt):
            collect(computer, CONFIG, boat, [], out)
    else:
        with full_disk(), pytest.raises(OSError, match=str(out)):
            collect(computer, CONFIG, boat, [], out)
    assert list(out.parent.iterdir()) == []


def interrupted(*_: object) -> None:
    raise KeyboardInterrupt


CONDITIONS = flotilla.supervisor_conditions()


@pytest.mark.parametrize(
    ("unmet", "level"),
    [("escs_online", BAD), ("parameters_saved", BAD), ("own_fresh", DOUBT), ("", DOUBT)],
)
def test_conditions_that_prevent_arming_are_bad_and_others_are_doubts(
    patient: Patient, unmet: str, level: Level
) -> None:
    """Asks a boat that sends COND and COND2, or COND2 alone."""
    boat = mavlink.MAVLink(None, SYSTEM, 1)
    beat = mavlink.MAVLink_heartbeat_message(11, 0, 1, 4, 3, 3)
    met = sum(1 << c["bit"] for c in CONDITIONS if c["name"] != unmet)
    halves = {b"COND": met % (1 << 24), b"COND2": met >> 24}
    if not unmet:
        del halves[b"COND"]
    words = [
        mavlink.MAVLink_named_value_float_message(0, name, float(half))
        for name, half in halves.items()
    ]
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end,
        ThreadPoolExecutor(1) as pool,
    ):
        end.bind(("127.0.0.1", patient.port))
        end.settimeout(0.05)
        future = pool.submit(lambda: list(examine(Computer(patient.root), CONFIG, 0.1)))
        while not future.done():
            with suppress(TimeoutError):
                _, doctor = end.recvfrom(4096)
                for message in (beat, *words):
                    end.sendto(message.pack(boat), doctor)
        found = [f for f in future.result() if f.where == "boat"]
    complaints = [c["complaint"] for c in CONDITIONS if c["name"] == unmet]
    what = complaints or ["its conditions are not heard in 2.5 s"]
    assert [(f.level, f.what) for f in found] == [(level, what[0])]


def test_without_permission_to_read_the_doctor_suggests_sudo_and_reports_no_fault() -> None:
    if os.geteuid() != 0 or not FLOTILLAD.exists():
        pytest.skip("SKIPPED: only root can look as nobody; or flotillad is not built")
    with TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        patient = Patient(Path(folder))
        patient.at("/var/lib/flotilla").chmod(0o750)
        try:
            done = told(patient, "--json", prefix=[*ordinary_user(), "setpriv", "--inh-caps=-all"])
        finally:
            patient.close()
    report = json.loads(done.stdout)
    doubts = {f["where"]: f["remedy"] for f in report["findings"] if f["level"] == "doubt"}
    assert report["ready"], report
    assert "sudo" in doubts[PARAMETERS] and "sudo" in doubts["serial:/dev/ttyNAV:115200"]


def test_parameters_of_a_damaged_file_are_none() -> None:
    assert saved("flotilla-parameters 1\nLAW_KX = 3\ncrc32 = 00000000") == {}


def test_a_missing_configuration_is_the_first_finding(tmp_path: Path) -> None:
    found = list(examine(Computer(tmp_path), CONFIG, 0.1))
    assert found[0].where == CONFIG and found[0].level is BAD
