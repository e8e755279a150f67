"""The Foxglove layout shows topics, fields and figures that exist."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from flexros.config.topics import load_topics

LAYOUT = json.loads((Path(__file__).parents[2] / "docs" / "foxglove" / "flexros.json").read_text(encoding="utf-8"))
PANELS: dict[str, dict[str, Any]] = LAYOUT["configById"]
PATHS = [path["value"] for panel in PANELS.values() for path in panel.get("paths", [])]
FIGURE = re.compile(r'/diagnostics\.status\[:\]\{name=="/plant"\}\.values\[:\]\{key=="(\w+)"\}\.value')
FIELD = re.compile(r"/(\w+)\.(\w+)\[\d\]")


def leaves(place: str | dict[str, Any]) -> Iterator[str]:
    if isinstance(place, str):
        yield place
    else:
        assert place["direction"] in ("row", "column")
        yield from (*leaves(place["first"]), *leaves(place["second"]))


def test_every_panel_has_a_place() -> None:
    assert sorted(leaves(LAYOUT["layout"])) == sorted(PANELS)
    kinds = {"3D", "Plot", "DiagnosticSummary", "DiagnosticStatusPanel", "Parameters"}
    assert {name.split("!")[0] for name in PANELS} == kinds


def test_arm_and_tool_are_shown_in_their_frame() -> None:
    arm = PANELS["3D!arm"]
    assert arm["followTf"] == "base"
    names = {name.removeprefix("/") for name in arm["topics"]}
    assert "arm_markers" in names
    assert names <= set(load_topics())


@pytest.mark.parametrize("path", PATHS)
def test_plotted_field_exists(path: str) -> None:
    topics = load_topics()
    if figure := FIGURE.fullmatch(path):
        assert f"status.values.{figure[1]}" in topics["diagnostics"].fields
        return
    field = FIELD.fullmatch(path)
    assert field
    assert field[2] in topics[field[1]].fields


def test_states_commands_and_diagnostics_are_plotted() -> None:
    plotted = {path.split(".")[0] for path in PATHS}
    assert plotted == {"/joint_states", "/joint_commands", "/joint_reference", "/diagnostics"}
