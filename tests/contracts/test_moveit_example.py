"""The files for MoveIt name what the exported URDF and the controller node have."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from ruamel.yaml import YAML

from flexros.robot import load_robot
from flexros.robot.exchange.urdf.export import urdf_text
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

FOLDER = Path(__file__).parents[2] / "docs" / "examples" / "moveit"


def read(name: str) -> dict:
    return YAML(typ="safe").load((FOLDER / name).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def urdf() -> ElementTree.Element:
    return ElementTree.fromstring(urdf_text(load_robot("six_axis")))


def moving(urdf: ElementTree.Element) -> list[str]:
    return [joint.get("name", "") for joint in urdf.findall("joint") if joint.get("type") != "fixed"]


def test_controller_moves_the_joints_of_the_urdf(urdf: ElementTree.Element) -> None:
    manager = read("moveit_controllers.yaml")["moveit_simple_controller_manager"]
    (name,) = manager["controller_names"]
    controller = manager[name]
    assert f"/{name}/{controller['action_ns']}" == "/controller/follow_joint_trajectory"
    assert controller["joints"] == moving(urdf) == list(load_robot("six_axis").joint_names)


def test_every_joint_has_limits_of_speed_and_acceleration(urdf: ElementTree.Element) -> None:
    limits = read("joint_limits.yaml")["joint_limits"]
    assert sorted(limits) == sorted(moving(urdf))
    assert all(limit["max_velocity"] > 0 and limit["max_acceleration"] > 0 for limit in limits.values())


def test_group_is_a_chain_of_the_urdf(urdf: ElementTree.Element) -> None:
    semantic = ElementTree.parse(FOLDER / "six_axis.srdf").getroot()
    assert semantic.get("name") == urdf.get("name")
    links = {link.get("name") for link in urdf.findall("link")}
    chain = semantic.find("group/chain")
    assert chain is not None
    assert {chain.get("base_link"), chain.get("tip_link")} <= links
    assert semantic.find("group").get("name") in read("kinematics.yaml")


def test_scenario_waits_with_a_law_that_takes_trajectories() -> None:
    scenario = load_scenario(FOLDER / "six_axis_moveit.yaml")
    assert not scenario.controller.follows_link_motion
    experiment = Experiment.prepare(scenario.with_values({"duration": 1.0}))
    assert experiment.trajectory.duration == experiment.trajectory.rest_before
