# SPDX-License-Identifier: MIT
"""Saved parameters are in force after every start; damaged files are reported and rejected."""

import os
import signal
import zlib
from pathlib import Path

import pytest

from sil.live.parameter_file import parameter_text
from tests.linux.process import PATIENT, STORAGE, RealSea, now_us
from tests.target.stations import ACCEPTED, ARM, command_long

NOT_SAVED = "PreArm: parameters or fence are not saved"


def text(*lines: str, **values: float) -> str:
    return parameter_text(PATIENT | values, *lines)


def is_whole(content: str) -> bool:
    body, _, checksum = content.rpartition("crc32 = ")
    return int(checksum, 16) == zlib.crc32(body.encode())


@pytest.fixture
def file(sea: RealSea) -> Path:
    sea.state_dir.mkdir()
    return sea.state_dir / "parameters.txt"


def previous(file: Path) -> Path:
    return file.with_name("parameters.txt.previous")


def test_a_boat_without_saved_parameters_reports_it_and_does_not_arm(sea: RealSea) -> None:
    sea.set_up = False
    sea.start()
    sea.insist(lambda: NOT_SAVED in sea.texts(), ARM, 1.0)
    assert "parameters are default or old: check and save them" in sea.texts()
    assert f"no {sea.state_dir}/parameters.txt: never set up, or lost" in sea.process.words
    assert "ALL PARAMETERS ARE DEFAULTS" in sea.process.words
    assert not sea.armed
    assert sea.end() == 0
    assert not (sea.state_dir / "parameters.txt").exists()  # nor at the next start

    sea.start()
    sea.save_parameters()
    sea.arm()


def test_setting_a_parameter_of_a_new_boat_sets_it_up(sea: RealSea) -> None:
    sea.set_up = False
    sea.start()
    sea.until(sea.ready)
    sea.set_parameter("LAW_KX", 0.25)
    sea.until(lambda: "saved (changed)" in sea.process.words)
    sea.arm()


def test_a_boat_that_was_set_up_starts_without_a_complaint_and_arms(sea: RealSea) -> None:
    sea.start()
    sea.save_parameters()  # all of them
    assert sea.end() == 0
    sea.start()
    sea.arm()
    assert sea.process.words.splitlines() == [f"flotillad: ready: boat 2 on mcast:{sea.bus}"]


def test_a_damaged_file_is_reported_and_the_previous_one_used(sea: RealSea, file: Path) -> None:
    damaged = text(CAN_NODE=34).replace("CAN_NODE = 34", "CAN_NODE = 35")
    file.write_text(damaged)
    previous(file).write_text(text(CAN_NODE=33))
    sea.start(param={})
    sea.insist(lambda: NOT_SAVED in sea.texts(), ARM, 1.0)
    assert sea.source_node() == 33
    assert "parameters.txt is damaged" in sea.process.words
    assert "parameters loaded from parameters.txt.previous" in sea.process.words
    assert sea.end() == 0
    assert file.read_text() == damaged  # for an operator to look at

    sea.start(param={})
    sea.save_parameters()
    assert is_whole(file.read_text()) and "CAN_NODE = 33\n" in file.read_text()
    sea.arm()


def test_beside_a_file_of_a_newer_version_the_previous_one_must_be_confirmed(
    sea: RealSea, file: Path
) -> None:
    body = "flotilla-parameters 2\n"
    newer = body + f"crc32 = {zlib.crc32(body.encode()):08X}\n"
    file.write_text(newer)
    previous(file).write_text(text(CAN_NODE=33))
    sea.start(param={})
    sea.insist(lambda: NOT_SAVED in sea.texts(), ARM, 1.0)
    assert sea.source_node() == 33
    assert sea.end() == 0
    assert file.read_text() == newer
    sea.start(param={})
    sea.save_parameters()
    sea.arm()


def test_with_both_files_damaged_an_operator_has_to_look_at_the_defaults(
    sea: RealSea, file: Path
) -> None:
    file.write_text(text(CAN_NODE=34)[:-1])
    previous(file).write_text("")
    sea.start()
    sea.insist(lambda: NOT_SAVED in sea.texts(), ARM, 1.0)
    assert "ALL PARAMETERS ARE DEFAULTS" in sea.process.words
    assert not sea.armed
    assert sea.source_node() == 20

    sea.save_parameters()
    assert (STORAGE, ACCEPTED) in sea.acks()
    sea.arm()
    sea.say(command_long(ARM, 0.0))
    sea.until(lambda: not sea.armed)
    assert sea.end() == 0

    sea.start(param={})
    sea.arm()
    assert NOT_SAVED not in sea.texts()


def test_defaults_that_nobody_has_confirmed_are_not_written_at_exit(
    sea: RealSea, file: Path
) -> None:
    damaged = text(CAN_NODE=34)[:-1]
    file.write_text(damaged)
    sea.start()
    sea.until(sea.ready)
    assert sea.end() == 0
    assert file.read_text() == damaged


def test_names_of_another_version_are_reported_and_kept(sea: RealSea, file: Path) -> None:
    file.write_text(text("LAW_MAGIC = 7", "a line of another age", LAW_KX=0.25))
    sea.start(param={})
    sea.until(sea.ready)
    sea.until(lambda: '"LAW_MAGIC" is unknown to this version and kept' in sea.process.words)
    sea.save_parameters()
    saved = file.read_text()
    assert is_whole(saved)
    assert {"LAW_MAGIC = 7", "a line of another age", "LAW_KX = 0.25"} <= set(saved.splitlines())
    sea.arm()
    assert sea.end() == 0
    assert file.read_text() == saved


def test_a_parameter_on_the_command_line_wins_and_is_not_written_at_exit(
    sea: RealSea, file: Path
) -> None:
    file.write_text(text(CAN_NODE=33))
    sea.start("--param=CAN_NODE=44", param={})
    sea.until(sea.ready)
    assert sea.source_node() == 44
    assert sea.end() == 0
    assert "CAN_NODE = 33\n" in file.read_text()
    sea.start(param={})
    sea.until(sea.ready)
    assert sea.source_node() == 33


def test_parameters_saved_while_armed_survive_a_power_cut(sea: RealSea, file: Path) -> None:
    sea.start("--param=LAW_KX=0.25")
    sea.enter_formation()
    sea.save_parameters()
    assert sea.armed
    sea.end(signal.SIGKILL)
    saved = file.read_text()
    assert is_whole(saved) and "LAW_KX = 0.25\n" in saved


def test_parameters_set_while_armed_survive_a_power_cut(sea: RealSea, file: Path) -> None:
    sea.start("--param=FORM_OFS_N=2")
    sea.enter_formation()
    sea.set_parameter("LAW_KX", 0.25)
    sea.until(lambda: "saved (changed)" in sea.process.words)
    assert sea.armed
    sea.end(signal.SIGKILL)
    saved = file.read_text()
    assert is_whole(saved) and "LAW_KX = 0.25\n" in saved
    assert "FORM_OFS_N = 0\n" in saved  # a value from the command line is not saved


def test_the_last_step_of_a_slider_is_the_one_that_is_saved(sea: RealSea, file: Path) -> None:
    sea.start()
    sea.until(sea.ready)
    began_us = now_us()
    for step in range(30):
        sea.set_parameter("LAW_KX", step / 32)
    sea.until(lambda: file.exists() and "LAW_KX = 0.90625\n" in file.read_text())
    elapsed_s = 1e-6 * (now_us() - began_us)
    assert sea.process.words.count("saved (changed)") <= elapsed_s + 2


def test_parameters_set_after_a_fall_to_defaults_are_saved_when_an_operator_requests_it(
    sea: RealSea, file: Path
) -> None:
    file.write_text("")
    sea.start()
    sea.until(sea.ready)
    sea.set_parameter("LAW_KX", 0.25)
    sea.run(1.5)
    assert file.read_text() == ""
    assert sea.end() == 0
    assert file.read_text() == ""

    sea.start()
    sea.until(sea.ready)
    sea.set_parameter("LAW_KX", 0.25)
    sea.save_parameters()
    assert "LAW_KX = 0.25\n" in file.read_text()


def test_parameters_set_just_before_the_end_are_saved_at_exit(sea: RealSea, file: Path) -> None:
    sea.start()
    sea.until(sea.ready)
    sea.set_parameter("LAW_KX", 0.5)
    sea.set_parameter("LAW_KX", 0.25)
    assert sea.end() == 0
    assert "LAW_KX = 0.25\n" in file.read_text()


def test_a_disk_that_hangs_does_not_stop_the_control_loop(sea: RealSea, file: Path) -> None:
    os.mkfifo(file.with_name("parameters.txt.new"))  # no reader: the save blocks for ever
    sea.start()
    sea.enter_formation()
    sea.insist(lambda: (STORAGE, ACCEPTED) in sea.acks(), STORAGE, 1.0)
    sea.run(0.5)
    sea.forget()
    sea.until(lambda: len(sea.raw_commands()) > 100 and sea.state == "FORMATION")
    assert sea.driven()
    assert "saved" not in sea.process.words


def test_a_failed_save_is_reported_once_and_tried_again(sea: RealSea, file: Path) -> None:
    obstacle = file.with_name("parameters.txt.new")
    sea.start()
    sea.until(sea.ready)

    def count(what: str) -> int:
        return sea.process.words.count(what)

    def set_where_the_disk_takes_it_later(gain: float) -> None:
        faults, saves = count("cannot be written"), count("saved (changed)")
        obstacle.mkdir()
        sea.set_parameter("LAW_KX", gain)
        sea.until(lambda: count("cannot be written") > faults)
        sea.run(2.5)  # two more attempts
        obstacle.rmdir()
        sea.until(lambda: count("saved (changed)") > saves)
        assert f"LAW_KX = {gain}\n" in file.read_text()
        assert count("cannot be written") == faults + 1

    set_where_the_disk_takes_it_later(0.25)
    set_where_the_disk_takes_it_later(0.5)


def test_a_failed_save_is_reported_and_the_boat_does_not_arm(sea: RealSea, file: Path) -> None:
    file.write_text("")
    file.with_name("parameters.txt.new").mkdir()  # where the new version would be written
    sea.start()
    sea.insist(lambda: "cannot be written" in sea.process.words, STORAGE, 1.0)
    sea.insist(lambda: NOT_SAVED in sea.texts(), ARM, 1.0)
    assert not sea.armed
