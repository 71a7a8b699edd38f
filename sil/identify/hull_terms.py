# SPDX-License-Identifier: MIT
"""The numbers that are estimated from a log, with the prior of each.

Forces and inertias are divided by m11: a log of motion and commands determines ratios only. Speeds
m/s and rad/s, lengths m, times s, angles rad, commands −1 … 1.
"""

from dataclasses import dataclass, replace

_LENGTH_M = 1.2  # of the hull that the guesses below are for


@dataclass(frozen=True)
class Term:
    """One number: first guess, standard deviation of the guess, least and greatest value.

    Guess, deviation and bounds are for a hull 1.2 m long and grow with its length to the power
    `metres`.
    """

    name: str
    guess: float
    spread: float
    least: float
    greatest: float
    metres: int
    meaning: str

    def of_length(self, length_m: float) -> "Term":
        """The same term for a hull of another length."""
        scale = (length_m / _LENGTH_M) ** self.metres
        return replace(
            self,
            guess=scale * self.guess,
            spread=scale * self.spread,
            least=scale * self.least,
            greatest=scale * self.greatest,
        )


TERMS = (
    Term("m22", 1.5, 0.4, 0.8, 6.0, 0, "inertia in sway"),
    Term("m33", 0.15, 0.5, 0.003, 10.0, 2, "inertia in yaw"),
    Term("m23", 0.0, 0.05, -1.0, 1.0, 1, "coupling of sway and yaw"),
    Term("d11", 0.5, 2.0, 0.0, 60.0, 0, "drag ahead, linear"),
    Term("d11_quadratic", 0.3, 1.0, 0.0, 60.0, -1, "drag ahead, quadratic"),
    Term("d22", 1.0, 3.0, 0.0, 100.0, 0, "drag sideways, linear"),
    Term("d22_quadratic", 1.0, 3.0, 0.0, 100.0, -1, "cross-flow drag along the hull"),
    Term("d22_speed", 0.0, 0.3, 0.0, 20.0, -1, "drag sideways that grows with speed ahead"),
    Term("d33", 0.3, 1.0, 0.0, 100.0, 2, "yaw damping, linear"),
    Term("d33_quadratic", 0.1, 0.5, 0.0, 100.0, 2, "yaw damping, quadratic"),
    Term("d33_speed", 0.1, 0.5, 0.0, 20.0, 1, "yaw damping that grows with speed ahead"),
    Term("munk", 0.0, 0.3, -5.0, 5.0, 0, "Munk moment (u v) beyond the inertias'"),
    Term("forward", 1.5, 20.0, 0.05, 60.0, 0, "thrust of one propeller, full ahead"),
    Term("reverse", 0.8, 0.3, 0.05, 3.0, 0, "thrust full astern as a share of full ahead"),
    Term("gain", 0.0, 0.07, -0.6, 0.6, 0, "starboard stronger, port weaker by this share"),
    Term("gain_reverse", 0.0, 0.07, -0.6, 0.6, 0, "the same astern"),
    Term("expo", 0.3, 0.5, 0.0, 1.0, 0, "thrust curve: 0 linear, 1 quadratic"),
    Term("dead", 0.02, 0.05, 0.0, 0.3, 0, "dead band of the command"),
    Term(
        "advance", 0.0, 0.1, 0.0, 2.0, 0, "thrust lost for each m/s of speed ahead, share of full"
    ),
    Term("lag", 0.2, 0.2, 0.005, 2.0, 0, "thrust lag"),
    Term("dead_time", 0.1, 0.2, 0.0, 1.0, 0, "dead time of the loop"),
    Term("antenna_x", 0.0, 0.05, -3.0, 3.0, 1, "antenna ahead of the reference point"),
    Term("antenna_y", 0.0, 0.05, -3.0, 3.0, 1, "antenna to starboard of it"),
    Term("late_position", 0.0, 0.05, -0.5, 1.0, 0, "latency of the position beyond the heading's"),
    Term("late_rate", 0.0, 0.05, -0.5, 0.5, 0, "latency of the yaw rate beyond the heading's"),
    Term("late_velocity", 0.0, 0.05, -0.5, 0.5, 0, "latency of the velocity beyond the heading's"),
    Term("compass", 0.0, 0.05, -1.0, 1.0, 0, "compass deviation, constant"),
    Term("compass_sin", 0.0, 0.05, -1.0, 1.0, 0, "compass deviation × sin ψ"),
    Term("compass_cos", 0.0, 0.05, -1.0, 1.0, 0, "compass deviation × cos ψ"),
    Term("wind_x", 0.0025, 0.001, 0.0, 0.1, -1, "wind force from ahead"),
    Term("wind_y", 0.008, 0.004, 0.0, 0.2, -1, "wind force abeam"),
    Term("wind_n", 0.0, 0.002, 0.0, 0.1, 0, "wind moment in yaw, greatest at 45° to the bow"),
)
# One of each for every log.
LOCAL = (
    Term("current_north", 0.0, 0.05, -2.0, 2.0, 0, "current"),
    Term("current_east", 0.0, 0.05, -2.0, 2.0, 0, "current"),
    Term("wind_north", 0.0, 2.0, -20.0, 20.0, 0, "wind"),
    Term("wind_east", 0.0, 2.0, -20.0, 20.0, 0, "wind"),
)
# One of each for every window, in addition to its log's: gusts and waves.
GUSTS = (
    Term("gust_north", 0.0, 0.4, -20.0, 20.0, 0, "wind beyond the log's"),
    Term("gust_east", 0.0, 0.4, -20.0, 20.0, 0, "wind beyond the log's"),
    Term("gust_turn", 0.0, 0.0015, -2.0, 2.0, 1, "moment of a gust"),
    Term("gust_north_rise", 0.0, 0.25, -20.0, 20.0, 0, "its change in half a window"),
    Term("gust_east_rise", 0.0, 0.25, -20.0, 20.0, 0, "its change in half a window"),
    Term("gust_turn_rise", 0.0, 0.0009, -2.0, 2.0, 1, "its change in half a window"),
)
NAMES = tuple(term.name for term in TERMS)
INDEX = {name: k for k, name in enumerate(NAMES)}
# Terms that change the measurements of a motion, but not the motion.
MEASURED = NAMES[INDEX["antenna_x"] : INDEX["compass_cos"] + 1]
