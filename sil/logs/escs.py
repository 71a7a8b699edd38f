# SPDX-License-Identifier: MIT
"""Writes ESC telemetry, from CAN or from the boat's MAVLink, to `/BOAT/esc/INDEX`."""

from sil.logs.esc_messages import Escs
from sil.logs.output import Output
from sil.wire.dronecan import ESC_STATUS, EscStatus
from sil.wire.dronecan_transfer import Receiver, message_subject

_SUBJECT = message_subject(ESC_STATUS)
_ZERO_degC = 273.15


class EscBus:
    """Decodes esc.Status from the frames on a boat's bus."""

    def __init__(self, output: Output, boat: str) -> None:
        self._output = output
        self._boat = boat
        self._receiver = Receiver({_SUBJECT: ESC_STATUS})

    def on_frame(self, t_us: int, can_id: int, data: bytes) -> None:
        """Process a frame (29-bit identifier) at its time in the log."""
        payload = self._receiver.on_frame(can_id, data, t_us)
        if payload is None:
            return
        try:
            status = EscStatus.decode(payload)
        except ValueError:
            return
        values = {
            "rpm": float(status.rpm),
            "voltage_V": status.voltage_V,
            "current_A": status.current_A,
            "temperature_degC": status.temperature_K - _ZERO_degC,
            "power_percent": float(status.power_pct),
            "errors": float(status.error_count),
        }
        self._output.own(1000 * t_us, f"/{self._boat}/esc/{status.esc_index}", "Esc", values)


class EscReport:
    """A boat's report of its ESCs: each ESC_STATUS with the values of the last ESC_INFO."""

    def __init__(self, output: Output, boat: str) -> None:
        self._output = output
        self._boat = boat
        self._info: Escs = {}

    def on_info(self, escs: Escs) -> None:
        """Keep the values of an ESC_INFO."""
        self._info.update(escs)

    def on_status(self, t_ns: int, escs: Escs) -> None:
        """Write an ESC_STATUS; skips unused indices, whose values are all zero."""
        for index, values in escs.items():
            if index in self._info or any(values.values()):
                known = {**self._info.get(index, {}), **values}
                self._output.own(t_ns, f"/{self._boat}/esc/{index}", "Esc", known)
