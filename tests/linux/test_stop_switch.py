# SPDX-License-Identifier: MIT
"""A stop switch on a GPIO line that is not there: nobody knows whether it is pressed."""

from tests.linux.process import RealSea


def test_an_unreadable_switch_counts_as_pressed_and_is_reported(sea: RealSea) -> None:
    sea.start("--stop-gpio=gpiochip250:7")
    words = "stop switch gpiochip250: No such file or directory, counts as pressed"
    sea.until(lambda: words in sea.process.words)
    sea.until(lambda: "stop switch is pressed, or its wire is cut" in sea.texts())
    assert "FAULT: terminated, disarm to leave" in sea.texts()
