"""A load written into a link of a URDF, against MuJoCo's model of both."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.record.balance.inverse_dynamics import rigid_arm
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

URDF = Path(__file__).parents[4] / "docs" / "examples" / "ur5e.urdf"
PATCH = """
robot: ur5e.yaml
effects:
  - effect: tool_load
    location: tool
    parameters: {mass: {value: 1.5}, x: {value: 0.01}, y: {value: 0.07}, z: {value: 0.02}}
"""


def test_weight_and_inertia_are_those_of_the_patch(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "ur5e.yaml").write_text(robot_from_urdf(URDF).text)
    (tmp_path / "patch.yaml").write_text(PATCH)
    patched = load_patched(str(tmp_path / "patch.yaml"))
    exported = export_model(patched, "urdf", URDF)
    where = "0.01, 0.07, 0.02 m from its joint, along the axes of the base at zero pose"
    mass, *others = [each.quantity for each in exported.written]
    assert mass == f"load of 1.5 kg at {where}: mass"
    assert set(others) == {*(f"centre of mass {axis}" for axis in "xyz"), "inertia"}
    (tmp_path / "loaded.urdf").write_text(exported.text)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "loaded.urdf"))
    data = mujoco.MjData(model)
    sign = np.array([1, 1, 1, 1, -1, 1])  # wrist_2 counts the other way
    data.qpos[:] = [0.3, -1.4, 1.5, -0.9, 1.2, 0.4]
    data.qvel[:] = [0.2, -0.3, 0.5, 0.7, -0.4, 0.6]
    data.qacc[:] = [1.0, -2.0, 0.5, 3.0, 2.0, -4.0]
    motion = sign * np.array([data.qpos, data.qvel, data.qacc])
    mujoco.mj_inverse(model, data)
    torque = rigid_arm(patched.model.robot).inverse_dynamics(motion[:, None]).torque[0]
    np.testing.assert_allclose(sign * torque, data.qfrc_inverse, rtol=1e-5, atol=1e-5)


def test_mjcf_of_the_user_has_it_as_a_new_file(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "ur5e.yaml").write_text(robot_from_urdf(URDF).text)
    (tmp_path / "patch.yaml").write_text(PATCH)
    base = tmp_path / "base.xml"
    base.write_text(export_model(load_patched(str(tmp_path / "ur5e.yaml")), "mjcf").text)
    patched = load_patched(str(tmp_path / "patch.yaml"))
    exported, new = export_model(patched, "mjcf", base), export_model(patched, "mjcf")
    assert exported.not_held == ()
    ours, theirs = (mujoco.MjModel.from_xml_string(each.text) for each in (exported, new))
    for array in ("body_mass", "body_ipos", "body_inertia"):
        np.testing.assert_allclose(getattr(ours, array), getattr(theirs, array), rtol=1e-9, atol=1e-12, err_msg=array)
