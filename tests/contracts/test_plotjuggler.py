"""The PlotJuggler layout shows topics and fields that exist, named as PlotJuggler names them."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from flexros.config.topics import load_topics

LAYOUT = ET.parse(Path(__file__).parents[2] / "docs" / "plotjuggler" / "flexros.xml")
CURVES = [curve.attrib["name"] for curve in LAYOUT.iter("curve")]
JOINT = re.compile(r"/(joint_states|joint_commands|joint_reference|link_states)/motor_[1-6]/(position|effort)")
POSE = re.compile(r"/(tool_pose|tool_reference)/pose/position/[xyz]")


@pytest.mark.parametrize("name", sorted(set(CURVES)))
def test_drawn_field_exists(name: str) -> None:
    joint = JOINT.fullmatch(name)
    if joint is None:
        assert POSE.fullmatch(name)
        assert name.split("/")[1] in load_topics()
    else:
        assert joint[2] in load_topics()[joint[1]].fields


def test_positions_torques_and_tool_are_drawn() -> None:
    assert {name.split("/")[1] for name in CURVES} == {
        "joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference", "link_states",
    }  # fmt: skip


def test_splitters_have_a_size_for_each_part() -> None:
    for splitter in LAYOUT.iter("DockSplitter"):
        parts = len(splitter.findall("DockArea"))
        assert int(splitter.attrib["count"]) == parts == len(splitter.attrib["sizes"].split(";"))
