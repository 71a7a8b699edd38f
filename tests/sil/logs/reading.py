# SPDX-License-Identifier: MIT
"""Reads MCAP files with MCAP's own reader."""

from collections import defaultdict
from pathlib import Path
from typing import Any

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from tests.turns import some

FOXGLOVE = {
    "fix": "foxglove.LocationFix",
    "tf": "foxglove.FrameTransforms",
    "log": "foxglove.Log",
    "scene": "foxglove.SceneUpdate",
}
OURS = {"state": "flotilla.State", "law": "flotilla.Law", "status": "flotilla.Status"}


def messages_of(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """By topic, the messages with their times, ns, in order of time."""
    topics: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            topics[channel.topic].append((message.log_time, decoded))
    return topics


def schemas_of(path: Path) -> dict[str, str]:
    """By topic, the name of its schema; asserts complete descriptors."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    names = {}
    for channel in some(summary.channels.values()):
        schema = summary.schemas[channel.schema_id]
        assert (channel.message_encoding, schema.encoding) == ("protobuf", "protobuf")
        pool = DescriptorPool()
        for one in FileDescriptorSet.FromString(schema.data).file:
            pool.Add(one)
        assert pool.FindMessageTypeByName(schema.name).fields
        names[channel.topic] = schema.name
    return names


def assert_schemas_are_by_topic(path: Path) -> None:
    for topic, name in some(schemas_of(path).items()):
        kind = "esc" if "/esc/" in topic else topic.rpartition("/")[2]
        assert name == {**FOXGLOVE, **OURS, "esc": "flotilla.Esc"}[kind]
