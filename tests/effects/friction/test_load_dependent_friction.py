"""Friction in proportion to the torque that a gear transmits: its law, sticking, convergence."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.arrays import FloatArray
from flexros.effects.friction.load_dependent_friction import LoadDependentFriction
from flexros.robot import Robot, load_robot, robot_from_data
from flexros.simulate.plant_model import PlantModel
from tests.effects import effect_runs, single_mass
from tests.effects.effect_runs import laws_of, run

TWO_MASS = load_robot("two_mass")  # 6 kg m2 at the arm, 4 at the motor
SHARE, INERTIA, WEIGHT = 0.2, 0.5, 20.0
PENDULUM = {
    "name": "pendulum",
    "defaults": {"source": "chosen", "tolerance": 0.05},
    "gravity": [0, 0, -10.0],
    "bodies": [
        {
            "mass": 4.0,
            "center_of_mass": [0.5, 0, 0],
            "inertia": {"xx": 0.1, "yy": 1.0, "zz": 1.0},
            "length": [1, 0, 0],
            "directions": {"ry": {"spring": "rigid", "damper": 0, "motor": {"inertia": INERTIA}}},
        }
    ],
    "outputs": {"tool": {"pose": ["x", "z"]}, "joints": {"coordinates": ["body_1.ry"]}},
    "controlled": "joints",
}
"""A rigid arm of 2 kg m2 about its joint, with a weight of 20 Nm where it is level."""


def pendulum() -> Robot:
    return robot_from_data(PENDULUM, "pendulum")


def test_sliding_motor_behind_a_spring_follows_its_law() -> None:
    start = np.array([0.0, 0.0, 2.0, 2.0])
    laws = laws_of(TWO_MASS, f"load_dependent_friction@motor_1:share={SHARE}")
    samples = 200
    path = run(TWO_MASS, laws, samples, lambda time: np.array([40.0 * np.sin(30 * time)]), start, substeps=8)
    stiffness, damping = (TWO_MASS.parameters[f"body_1.rz.{name}"].value for name in ("stiffness", "damping"))

    def slope(time: float, x: FloatArray) -> list[float]:
        load = stiffness * (x[1] - x[0]) + damping * (x[3] - x[2])
        driven = 40.0 * np.sin(30 * np.floor(time / TWO_MASS.sample_time + 1e-9) * TWO_MASS.sample_time)
        return [x[2], x[3], load / 6.0, (driven - load - SHARE * abs(load) * np.sign(x[3])) / 4.0]

    times = TWO_MASS.sample_time * np.arange(samples + 1)
    exact = solve_ivp(slope, (0.0, times[-1]), start, t_eval=times, rtol=1e-10, atol=1e-12, max_step=1e-4).y.T
    assert np.min(path[:, 3]) > 0.5
    without = run(TWO_MASS, (), samples, lambda time: np.array([40.0 * np.sin(30 * time)]), start)
    assert np.max(np.abs(without - exact)) > 0.05
    np.testing.assert_allclose(path, exact, atol=2e-5)


def test_sliding_motor_behind_a_rigid_gear_carries_what_the_arm_needs() -> None:
    """Forward and backward: torque u = J a + T + s |T| sign(v) with T = 2 a + 20 cos(q), the torque on the arm."""
    robot = pendulum()
    for direction in (1.0, -1.0):
        model = PlantModel(robot, laws_of(robot, f"load_dependent_friction@motor_1:share={SHARE}"))
        path = effect_runs.run(robot, model.laws, 200, lambda time: np.array([-12.0]), np.array([0.4, direction]), 16)
        v = path[:, 1]
        a = np.gradient(v, robot.sample_time)[2:-2]
        needed = robot.model.arm_inverse_dynamics
        load = np.array([float(needed(*row, [])) for row in zip(path[2:-2, 0], v[2:-2], a)])
        moving = np.abs(v[2:-2]) > 0.05
        torque = INERTIA * a + load + SHARE * np.abs(load) * np.sign(v[2:-2])
        assert np.count_nonzero(moving) > 50
        np.testing.assert_allclose(torque[moving], -12.0, atol=0.02)


def test_standstill_holds_up_to_the_share_of_the_weight() -> None:
    robot = pendulum()
    laws = laws_of(robot, f"load_dependent_friction@motor_1:share={SHARE}")
    hold = float(robot.holding_torque(robot.equilibrium())[0])
    weight = abs(hold)
    assert weight == pytest.approx(20.0)
    for push in (0.98 * SHARE * weight, -0.98 * SHARE * weight):
        held = run(robot, laws, 300, lambda time, push=push: np.array([hold + push]))
        assert np.max(np.abs(held - held[0])) < 1e-9
    slipping = run(robot, laws, 300, lambda time: np.array([hold + 1.02 * SHARE * weight]))
    assert abs(slipping[-1, 0]) > 1e-4


def test_slide_without_load_is_not_braked() -> None:
    """The force on a slide is its mass times its acceleration, which is zero without force."""
    path = single_mass.states(single_mass.plant("load_dependent_friction@motor_1:share=0.3", start=(0.0, 0.4)), 200)
    np.testing.assert_allclose(path[:, 1], 0.4, rtol=1e-12)


def test_substeps_converge_with_order_two_while_it_slides_behind_a_spring() -> None:
    laws = laws_of(TWO_MASS, f"load_dependent_friction@motor_1:share={SHARE}")
    start = np.repeat([0.0, 3.0], 2)
    errors = effect_runs.halving_errors(TWO_MASS, laws, 60, lambda time: np.array([30.0 * np.sin(60 * time)]), start)
    assert errors[0] < 1e-6
    assert np.log2(errors[0] / errors[-1]) / 3 > 1.8


def test_substeps_converge_behind_a_rigid_gear_through_reversals_and_standstill() -> None:
    def path(substeps: int) -> FloatArray:
        effect = f"load_dependent_friction@motor_1:share={SHARE}"
        moving = single_mass.plant(effect, start=(0.0, 0.5), substeps=substeps, sample_time=0.01, robot=pendulum())
        return single_mass.states(moving, 200, lambda time: -20.0 + 6.0 * np.sin(6 * time))[:, 0]

    exact = path(128)
    errors = [float(np.max(np.abs(path(substeps) - exact))) for substeps in (1, 4, 16)]
    assert np.count_nonzero(np.abs(np.diff(exact)) < 1e-9) > 10  # it stands still in between
    assert errors[0] < 5e-3 * np.ptp(exact)
    assert np.log2(errors[0] / errors[2]) / 4 > 0.9


@pytest.mark.parametrize("measured", [True, False])
def test_it_is_sought_where_the_load_varies_by_itself(measured: bool) -> None:
    """Behind a rigid gear without gravity the load is an inertia times the acceleration."""
    effect = LoadDependentFriction()
    sought = effect.sought_if_measured if measured else effect.sought
    assert sought(TWO_MASS, "motor_1")
    assert sought(pendulum(), "motor_1")
    assert not sought(load_robot("emps"), "motor_1")


def test_self_locking_gear_is_refused() -> None:
    with pytest.raises(ValueError, match="share"):
        LoadDependentFriction(share=1.0)
