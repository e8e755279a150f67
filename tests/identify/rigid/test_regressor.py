"""Regressor of the rigid robot against inverse dynamics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.feedforward.rigid_arm import RigidArm
from flexros.identify.rigid.regressor import RigidRegressor
from flexros.robot import load_robot, robot_names
from flexros.robot.robot import LIBRARY


def random_motion(motors: int, n: int = 40, seed: int = 5) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(3, n, motors))


def nominal(regressor: RigidRegressor) -> np.ndarray:
    return np.array([parameter.nominal for parameter in regressor.parameters])


@pytest.mark.parametrize("name", [name for name in robot_names() if name != "flexible_arm"])
def test_regressor_times_nominal_is_the_inverse_dynamics(name: str) -> None:
    robot = load_robot(name)
    motion = random_motion(robot.n_motors)
    regressor = RigidRegressor(robot)
    torque = RigidArm(robot).inverse_dynamics(motion).torque
    np.testing.assert_allclose(regressor.matrix(*motion) @ nominal(regressor), torque, atol=1e-12 * abs(torque).max())


def test_links_that_bend_are_refused() -> None:
    with pytest.raises(InputError, match="flexible_arm has links that bend"):
        RigidRegressor(load_robot("flexible_arm"))


def test_regressor_with_inertial_coupling_of_the_rotors(tmp_path: Path) -> None:
    file = tmp_path / "coupled.yaml"
    file.write_text((LIBRARY / "elbow.yaml").read_text() + "inertial_coupling: true\n")
    robot = load_robot(file)
    motion = random_motion(2)
    regressor = RigidRegressor(robot)
    torque = RigidArm(robot).inverse_dynamics(motion).torque
    np.testing.assert_allclose(regressor.matrix(*motion) @ nominal(regressor), torque, atol=1e-12 * abs(torque).max())
    uncoupled = RigidRegressor(load_robot("elbow"))
    assert np.abs(uncoupled.matrix(*motion) @ nominal(uncoupled) - torque).max() > 1e-4 * abs(torque).max()


def test_friction_columns_act_on_their_own_motor(elbow) -> None:
    regressor = RigidRegressor(elbow)
    motion = random_motion(2)
    H, names = regressor.matrix(*motion), [parameter.name for parameter in regressor.parameters]
    np.testing.assert_array_equal(H[:, 1, names.index("motor_2.coulomb_friction")], np.sign(motion[1][:, 1]))
    np.testing.assert_array_equal(H[:, 1, names.index("motor_2.viscous_friction")], motion[1][:, 1])
    assert not np.any(H[:, 0, names.index("motor_2.torque_offset")])


def test_asymmetric_friction_adds_up_to_the_symmetric_one(elbow) -> None:
    motion = random_motion(2)
    both, split = RigidRegressor(elbow), RigidRegressor(elbow, asymmetric=True)
    H, S = both.matrix(*motion), split.matrix(*motion)
    names, parts = ([parameter.name for parameter in r.parameters] for r in (both, split))
    for kind in ("viscous", "coulomb"):
        total = sum(S[..., parts.index(f"motor_1.{kind}_friction_{way}")] for way in ("forward", "backward"))
        np.testing.assert_array_equal(total, H[..., names.index(f"motor_1.{kind}_friction")])
    assert np.all(S[motion[1][:, 0] < 0, 0, parts.index("motor_1.coulomb_friction_forward")] == 0)


def test_long_motions_are_evaluated_in_parts(emps) -> None:
    motion = random_motion(1, n=2300)
    whole = RigidRegressor(emps).matrix(*motion)
    np.testing.assert_array_equal(whole[2100:2200], RigidRegressor(emps).matrix(*motion[:, 2100:2200]))
