# SPDX-License-Identifier: MIT
"""The layout for Foxglove and Lichtblick matches the file of a run of four boats."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from sil.cli.main import main
from sil.logs.run_folder import NAME
from tests.sil.logs.reading import messages_of, schemas_of
from tests.turns import some

LAYOUT = Path(__file__).parents[3] / "sil" / "logs" / "layout.json"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("run")
    assert main(["run", "turning", "--set", "duration_s=2", "--mcap", "--out", str(out)]) == 0
    return out / NAME


def panels(node: Any) -> Iterator[str]:
    """The panels of a part of a layout, those in tabs too."""
    if isinstance(node, dict):
        yield from panels(node["first"])
        yield from panels(node["second"])
    else:
        yield node


def test_every_panel_has_its_place_and_its_settings() -> None:
    layout = json.loads(LAYOUT.read_text())
    placed = list(panels(layout["layout"]))
    for settings in layout["configById"].values():
        placed += [name for tab in settings.get("tabs", ()) for name in panels(tab["layout"])]
    assert sorted(placed) == sorted(layout["configById"])
    kinds = {name.partition("!")[0] for name in placed}
    assert kinds == {"map", "3D", "Plot", "StateTransitions", "RosOut", "Tab"}


def test_every_path_leads_to_a_number_or_a_string_in_the_log(log: Path) -> None:
    topics = messages_of(log)
    paths = re.findall(r'"value": "(/[^"]*)"', LAYOUT.read_text())
    assert len(paths) == 24
    for path in paths:
        topic, _, field = path.partition(".")
        assert isinstance(getattr(topics[topic][-1][1], field), float | str)


def test_every_topic_that_is_shown_is_in_the_log_with_the_schema_that_its_panel_wants(
    log: Path,
) -> None:
    schemas = schemas_of(log)
    panels_of = json.loads(LAYOUT.read_text())["configById"]
    for topic in some(panels_of["map!flotilla"]["topicColors"]):
        assert schemas[topic] == "foxglove.LocationFix"
    for topic in some(panels_of["3D!flotilla"]["topics"]):
        assert schemas[topic] == "foxglove.SceneUpdate"
    for name in some(name for name in panels_of if name.startswith("RosOut!")):
        assert schemas[panels_of[name]["topicToRender"]] == "foxglove.Log"


def test_every_drawn_entity_belongs_to_a_frame_in_the_log(log: Path) -> None:
    topics = messages_of(log)
    frames = {one.child_frame_id for _, message in topics["/tf"] for one in message.transforms}
    for topic in some(topic for topic in topics if topic.endswith("/scene")):
        entities = [entity for _, message in topics[topic] for entity in message.entities]
        assert {entity.frame_id for entity in some(entities)} <= frames
        assert len(topics[topic][-1][1].entities) == (1 if "leader" in topic else 2)
