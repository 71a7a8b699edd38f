# SPDX-License-Identifier: MIT
"""A vessel's own telemetry: named values, battery, ESCs. Times are s."""

from math import isfinite, nan
from typing import Any

from sil.view.validity import LEAST_S, Validity
from sil.wire import mavlink_messages as messages

_RARE_S = 20.0  # least validity of values sent every 5 s
_UNKNOWN_mV, _UNKNOWN_cdegC = 65535, 32767
_MOST_VALUES = 100
_GROUP = 4
_DIGITS = {"rpm": 0, "voltage_V": 2, "current_A": 2, "temperature_C": 1, "errors": 0}
ESC_NUMBERS = tuple(_DIGITS)


class _Kept:
    """Numbers by name, each with its validity."""

    def __init__(self) -> None:
        self._numbers: dict[str, float] = {}
        self._valid: dict[str, Validity] = {}

    def put(self, name: str, number: float, now_s: float, least_s: float = LEAST_S) -> None:
        if name in self._numbers or len(self._numbers) < _MOST_VALUES:
            self._numbers[name] = number
            self._valid.setdefault(name, Validity()).renew(now_s, least_s)

    def get(self, name: str, now_s: float) -> float | None:
        number = self._numbers.get(name, nan)
        return number if isfinite(number) and now_s <= self._valid[name].until_s else None

    def lost_s(self, name: str, now_s: float) -> float | None:
        there = name in self._numbers and self.get(name, now_s) is None
        return now_s - self._valid[name].heard_s if there else None


class Aboard:
    """The last values; each query returns those still valid at `now_s`, None if unknown."""

    def __init__(self) -> None:
        self._values = _Kept()
        self._escs: dict[int, _Kept] = {}
        self._offline: set[int] = set()  # indices whose zeros in ESC_STATUS are not measurements
        self.indices = [0, 1]  # ESC_PORT and ESC_STBD, or their defaults

    def value(self, name: str, now_s: float) -> float | None:
        """The value of a NAMED_VALUE_FLOAT."""
        return self._values.get(name, now_s)

    def lost_s(self, name: str, now_s: float) -> float | None:
        """Age of a value that is no longer valid, s; None if it is valid or was never sent."""
        return self._values.lost_s(name, now_s)

    def battery_V(self, now_s: float) -> float | None:
        """The lowest voltage at the ESCs, reported by the boat."""
        return self._values.get("battery", now_s)

    def escs(self, now_s: float) -> list[dict[str, float | None]]:
        """The ESCs, port and starboard; empty for a vessel that reports none."""
        if not self._escs:
            return []
        kept = [
            _Kept() if index in self._offline else self._escs.get(index, _Kept())
            for index in self.indices
        ]
        return [
            {name: _round(esc.get(name, now_s), d) for name, d in _DIGITS.items()} for esc in kept
        ]

    def hear(self, number: int, fields: tuple[Any, ...], now_s: float) -> None:
        """Process a message of one of its components."""
        if (take := _TAKE.get(number)) is not None:
            take(self, fields, now_s)

    def _named_value(self, f: tuple[Any, ...], now_s: float) -> None:
        name = f[2].split(b"\0")[0].decode("ascii", "replace")
        self._values.put(name, f[1], now_s)

    def _system_status(self, f: tuple[Any, ...], now_s: float) -> None:
        volts = nan if f[4] == _UNKNOWN_mV else 0.001 * f[4]
        # Cannot collide: no NAMED_VALUE_FLOAT of ours begins with a small letter.
        self._values.put("battery", volts, now_s)

    def _esc_status(self, f: tuple[Any, ...], now_s: float) -> None:
        for i, esc in self._of_group(f[13]):
            for name, number in zip(
                ("rpm", "voltage_V", "current_A"), f[1 + i : 13 : 4], strict=True
            ):
                esc.put(name, number, now_s)

    def _esc_info(self, f: tuple[Any, ...], now_s: float) -> None:
        for i, esc in self._of_group(f[14]):
            warmth_C = nan if f[10 + i] == _UNKNOWN_cdegC else 0.01 * f[10 + i]
            esc.put("errors", f[1 + i], now_s, _RARE_S)
            esc.put("temperature_C", warmth_C, now_s, _RARE_S)
            online = f[17] >> i & 1
            (self._offline.discard if online else self._offline.add)(f[14] + i)

    def _of_group(self, first: int) -> list[tuple[int, _Kept]]:
        """For each propeller's ESC in this message of four: its place in it, and its values."""
        return [
            (index - first, self._escs.setdefault(index, _Kept()))
            for index in self.indices
            if first <= index < first + _GROUP
        ]

    def _parameter(self, f: tuple[Any, ...], _: float) -> None:
        name = f[3].split(b"\0")[0]
        if name in (b"ESC_PORT", b"ESC_STBD") and 0 <= f[0] < 20:
            self.indices[name == b"ESC_STBD"] = int(f[0])


def _round(number: float | None, digits: int) -> float | None:
    return None if number is None else round(number, digits or None)


_TAKE = {
    messages.NAMED_VALUE_FLOAT: Aboard._named_value,
    messages.SYS_STATUS: Aboard._system_status,
    messages.ESC_STATUS: Aboard._esc_status,
    messages.ESC_INFO: Aboard._esc_info,
    messages.PARAM_VALUE: Aboard._parameter,
}
