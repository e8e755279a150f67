"""Base parameters excited by a motion."""

from __future__ import annotations

import numpy as np

from flexros.identify.rigid.base_parameters import base_parameters
from flexros.identify.rigid.excitation import judge_excitation
from flexros.identify.rigid.regressor import RigidRegressor


def verdict(robot, q: np.ndarray, v: np.ndarray, a: np.ndarray):
    regressor = RigidRegressor(robot)
    base = base_parameters(regressor, robot.n_motors)
    return base, judge_excitation(regressor.matrix(q, v, a)[:, :, base.leading], base)


def test_random_motion_shows_everything(elbow) -> None:
    base, excitation = verdict(elbow, *np.random.default_rng(1).normal(size=(3, 300, 2)))
    assert excitation.not_excited == ()
    assert excitation.shown == tuple(range(len(base.names)))


def test_motor_at_rest_shows_neither_its_inertia_nor_its_friction(elbow) -> None:
    q, v, a = np.random.default_rng(1).normal(size=(3, 300, 2))
    q[:, 1], v[:, 1], a[:, 1] = 0.4, 0, 0
    _, excitation = verdict(elbow, q, v, a)
    reasons = {entry.name: entry.reason for entry in excitation.not_excited}
    for name in ("motor_2.inertia", "motor_2.viscous_friction", "motor_2.coulomb_friction"):
        assert reasons[name] == "nothing in the motion depends on it"
    assert "motor_1.viscous_friction" not in reasons


def test_constant_speed_confuses_friction_with_offset(emps) -> None:
    v = np.full((300, 1), 0.3)
    _, excitation = verdict(emps, np.cumsum(v, axis=0), v, np.zeros_like(v))
    reasons = {entry.name: entry.reason for entry in excitation.not_excited}
    assert reasons["body_1.mass"] == "nothing in the motion depends on it"
    assert reasons["motor_1.coulomb_friction"] == "in this motion it acts like motor_1.viscous_friction"
    assert reasons["motor_1.torque_offset"] == "in this motion it acts like motor_1.viscous_friction"
    assert excitation.shown == (1,)
