# SPDX-License-Identifier: MIT
"""Protobuf schemas of the MCAP messages for which Foxglove has none.

Every number is a double whose name ends in its unit; NaN is unknown. A field's number is its
position: append new fields at the end.
"""

from typing import Any

from foxglove import Schema
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

PACKAGE = "flotilla"
_DOUBLE = descriptor_pb2.FieldDescriptorProto.TYPE_DOUBLE
_STRING = descriptor_pb2.FieldDescriptorProto.TYPE_STRING
_OPTIONAL = descriptor_pb2.FieldDescriptorProto.LABEL_OPTIONAL

#: Pose north and east of the world's origin, clockwise from north; velocity in body axes.
STATE = ("x_m", "y_m", "psi_rad", "u_mps", "v_mps", "r_radps")
#: Formation error in body axes, desired velocities, wrench beyond the propellers' limits, ages,
#: estimates of unknown wrench and current, thrusts and their limits, supervisor's conditions.
LAW = (
    "error_x_m",
    "error_y_m",
    "error_psi_rad",
    "error_m",
    "wanted_u_mps",
    "wanted_r_radps",
    "lack_X_N",
    "lack_N_Nm",
    "own_age_s",
    "leader_age_s",
    "leader_uncertainty_m",
    "unknown_X_N",
    "unknown_N_Nm",
    "current_north_mps",
    "current_east_mps",
    "overruns",
    "thrust_port_N",
    "thrust_stbd_N",
    "thrust_max_N",
    "thrust_min_N",
    "leader",
    "conditions",
    "conditions2",
    "depth",
    "separation_m",
    "learnt_balance",
    "learnt_drag",
    "learnt_yaw_damping",
)
#: One ESC, with the values of esc.Status and ESC_STATUS.
ESC = ("rpm", "voltage_V", "current_A", "temperature_degC", "power_percent", "errors")
#: The supervisor's state as text, and the battery.
STATUS = ("state", "battery_V", "battery_A")

FIELDS = {"State": STATE, "Law": LAW, "Esc": ESC, "Status": STATUS}


def _file() -> Any:
    file = descriptor_pb2.FileDescriptorProto(
        name="flotilla.proto", package=PACKAGE, syntax="proto3"
    )
    for name, fields in FIELDS.items():
        message = file.message_type.add(name=name)
        for number, field in enumerate(fields, start=1):
            kind = _STRING if field == "state" else _DOUBLE
            message.field.add(name=field, number=number, type=kind, label=_OPTIONAL)
    return file


_FILE = _file()
_POOL = descriptor_pool.DescriptorPool()
_POOL.Add(_FILE)
_SET = descriptor_pb2.FileDescriptorSet(file=[_FILE]).SerializeToString()
_CLASSES = {
    name: message_factory.GetMessageClass(_POOL.FindMessageTypeByName(f"{PACKAGE}.{name}"))
    for name in FIELDS
}
_UNKNOWN = {
    name: {field: float("nan") for field in fields if field != "state"}
    for name, fields in FIELDS.items()
}


def schema(name: str) -> Schema:
    """The schema of a channel of message `name`, a key of FIELDS."""
    return Schema(name=f"{PACKAGE}.{name}", encoding="protobuf", data=_SET)


def encode(name: str, values: dict[str, Any]) -> bytes:
    """Encode a message; fields missing in `values` are NaN. ValueError for an unknown field."""
    data: bytes = _CLASSES[name](**{**_UNKNOWN[name], **values}).SerializeToString()
    return data
