"""Robots as SDF models."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.robot import load_robot
from flexros.robot.exchange.urdf.sdf_export import ENTRIES, sdf_text


def test_sdf_has_the_links_and_joints_of_the_urdf() -> None:
    urdf, sdf = (ElementTree.fromstring(export_model(load_patched("six_axis"), to).text) for to in ("urdf", "sdf"))
    assert {link.get("name") for link in urdf.iter("link")} == {link.get("name") for link in sdf.iter("link")}
    poses = {joint.get("name"): joint.findtext("pose") for joint in sdf.iter("joint")}
    for joint in urdf.iter("joint"):
        xyz = joint.find("origin").get("xyz")  # type: ignore[union-attr]
        assert poses[joint.get("name")] == f"{xyz} 0 0 0"


def test_every_link_has_a_mass_and_a_tensor_that_a_body_can_have() -> None:
    for name in ("elbow", "six_axis", "emps"):
        robot = load_robot(name)
        root = ElementTree.fromstring(sdf_text(robot))
        for link in root.iter("link"):
            assert float(link.findtext("inertial/mass", "0")) > 0
            tensor = np.zeros((3, 3))
            for key, (row, column) in ENTRIES.items():
                tensor[row, column] = tensor[column, row] = float(link.findtext(f"inertial/inertia/{key}", "0"))
            moments = np.linalg.eigvalsh(tensor)
            assert moments[0] > 0
            assert moments[2] <= (1 + 1e-9) * (moments[0] + moments[1])
        masses = sum(float(link.findtext("inertial/mass", "0")) for link in root.iter("link"))
        np.testing.assert_allclose(masses, sum(body.mass.value for body in robot.spec.bodies), rtol=1e-6)
