# SPDX-License-Identifier: MIT
"""MAVSDK as used by a script, in this process; the sea runs on while a call blocks."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any

import mavsdk
from mavsdk import ComponentType, Configuration, ConnectionResult, Mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.component_metadata import ComponentMetadata
from mavsdk.plugins.ftp import Ftp
from mavsdk.plugins.info import Info
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry

from tests.clients.boat import Waters

_LONGEST_CALL_S = 30.0


class MavsdkClient:
    """The synchronous API: blocking calls run in a thread, subscriptions fill lists."""

    def __init__(self, sea: Waters) -> None:
        self.sea = sea
        sea.client = self
        self._log: list[str] = []
        self._pool = ThreadPoolExecutor()
        self._calls: list[Future[Any]] = []
        kind = ComponentType.GROUND_STATION
        self._sdk = Mavsdk(Configuration.create_with_component_type(kind))
        mavsdk.log_subscribe(self._on_log)
        try:
            self._find_boat()
        except BaseException:
            self.close()
            raise

    def _find_boat(self) -> None:
        assert self._sdk.add_any_connection(self.sea.address) == ConnectionResult.SUCCESS
        self.system = self.call(self._sdk.first_autopilot, 10.0)
        assert self.system is not None, self.sea.words
        self.telemetry = Telemetry(self.system)
        self.action = Action(self.system)
        self.param = Param(self.system)
        self.info = Info(self.system)
        self.ftp = Ftp(self.system)
        self.metadata = ComponentMetadata(self.system)
        self.direct = MavlinkDirect(self.system)
        self._texts = self.watch("status_text")

    def close(self) -> None:
        """Close after waiting for a call that a failed test left running: it still uses the SDK."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        try:
            assert not wait(self._calls, _LONGEST_CALL_S).not_done, f"blocked; {self.words}"
            self._sdk.destroy()
        finally:
            mavsdk.log_unsubscribe()

    def _on_log(self, level: mavsdk.LogLevel, message: str, *_: object) -> bool:
        self._log.append(f"{level.name} {message}")
        return True

    @property
    def words(self) -> str:
        return "\n".join(self._log)

    @property
    def texts(self) -> list[str]:
        return [text.text for text in self._texts]

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a blocking function; its result or exception."""
        future = self._pool.submit(function, *arguments)
        self._calls.append(future)
        self.sea.until(future.done)
        return future.result()

    def watch(self, name: str) -> list[Any]:
        """A list that collects a Telemetry subscription from now on."""
        values: list[Any] = []
        getattr(self.telemetry, f"subscribe_{name}")(lambda value, _: values.append(value))
        return values

    def messages(self, name: str) -> list[dict[str, Any]]:
        """A list that collects the fields of all messages of that name from now on."""
        fields: list[dict[str, Any]] = []
        self.direct.subscribe_message(
            name, lambda message, _: fields.append(json.loads(message.fields_json))
        )
        return fields

    def command(self, number: int, *params: float) -> int:
        """Send a COMMAND_LONG; its MAV_RESULT."""
        boat = self.system.get_system_id()
        filled = [*params, *[0.0] * (7 - len(params))]
        fields = {
            "target_system": boat,
            "target_component": 1,
            "command": number,
            "confirmation": 0,
            **{f"param{i}": value for i, value in enumerate(filled, 1)},
        }
        message = MavlinkMessage("COMMAND_LONG", 0, 0, boat, 1, json.dumps(fields))
        ack = self.call(self.direct.send_command, message)
        result: int = json.loads(ack.fields_json)["result"]
        return result
