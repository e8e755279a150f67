"""Integral parts of servos: law, limit, rest, and their size from a log of positions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.arrays import FloatArray
from flexros.effects import parse_effect, place_effects
from flexros.effects.patching.patched_robot import PatchedRobot
from flexros.effects.patching.repaired_numbers import repaired_numbers
from flexros.errors import InputError
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.record.torques.servo_torque import servo_parts
from flexros.robot import Robot
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import SERVO_EFFECTS, T, servo_log, servo_robot

INTEGRAL = 150.0
"""Of a joint with the stiffness 60 Nm/rad and the damping 2 Nm s/rad [Nm/(rad s)]."""
INERTIA, VISCOUS, WEIGHT = 0.05 + 0.02 + 1.5 * 0.2**2, 0.3, 1.5 * 9.81 * 0.2


def with_integral(limit: float = 30.0, integral: float = INTEGRAL) -> Robot:
    return servo_robot(limit=limit, integral=integral).commanded_by("position")


def angles(robot: Robot, command: float, samples: int, substeps: int = 8) -> FloatArray:
    """Angles after a step of the command from 0, where the joint is upright without load."""
    plant = Plant(robot, T, np.zeros(2), torque=np.zeros(1), substeps=substeps)
    found = []
    for _ in range(samples):
        found.append(plant.state[0])
        plant.advance([command])
    return np.array(found)


def exact(command: float, samples: int, limit: float = np.inf) -> FloatArray:
    """The same by another integrator, with the integral at rest beyond the limit."""

    def slope(time: float, x: FloatArray) -> list[float]:
        error = command - x[0]
        wanted = 60.0 * error - 2.0 * x[1] + x[2]
        held = abs(wanted) > limit and wanted * error > 0
        torque = np.clip(wanted, -limit, limit)
        acceleration = (torque - VISCOUS * x[1] + WEIGHT * np.sin(x[0])) / INERTIA
        return [x[1], acceleration, 0.0 if held else INTEGRAL * error]

    times = T * np.arange(samples)
    return solve_ivp(slope, (0.0, times[-1]), [0.0, 0.0, 0.0], t_eval=times, rtol=1e-9, atol=1e-11, max_step=1e-3).y[0]


@pytest.mark.parametrize("limit", [30.0, 4.0])
def test_joint_follows_its_law_within_the_limit_and_at_it(limit: float) -> None:
    found = angles(with_integral(limit), 0.3, 500)
    np.testing.assert_allclose(found, exact(0.3, 500, limit), atol=2e-4 if limit < 18 else 1e-6)
    assert abs(found[-1] - 0.3) < 0.01
    assert abs(angles(with_integral(limit, 0.0), 0.3, 500)[-1] - 0.3) > 0.01  # it gives way to its weight


def test_substeps_converge_with_order_four() -> None:
    fine = angles(with_integral(), 0.3, 100, 64)
    errors = [np.max(np.abs(angles(with_integral(), 0.3, 100, substeps) - fine)) for substeps in (1, 2, 4)]
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 3.5)


def test_robot_that_starts_at_rest_stays_where_it_is_commanded() -> None:
    robot = with_integral()
    model, state = PlantModel(robot), robot.equilibrium(motor_position=np.array([0.7]))
    command = model.command_at_rest(state, robot.holding_torque(state), np.zeros(0))
    np.testing.assert_allclose(command, [0.7])
    plant = Plant(robot, T, state, torque=command)
    for _ in range(100):
        plant.advance(command)
    np.testing.assert_allclose(plant.state, state, atol=1e-12)


def test_integral_of_zero_is_neutral_to_the_last_bit() -> None:
    """Also as a parameter that a diagnosis fits."""
    robot = servo_robot().commanded_by("position")
    placed = place_effects(robot, [parse_effect("servo_integral@motor_1:gain=0", "test")])
    assert np.array_equal(angles(placed.robot, 0.3, 50), angles(robot, 0.3, 50))
    model = PlantModel(robot, (), ("motor_1.servo_integral",))
    assert model.n_states == PlantModel(robot).n_states + 1
    start = model.start(robot.equilibrium(motor_position=np.array([0.7])), np.array([0.7]), np.zeros(1))
    assert start[-1] == 0.0
    rate = model.derivative(start, np.array([0.9]), np.zeros(6), np.zeros(1)).full().ravel()
    assert rate[-1] == 0.0


def test_number_of_the_robot_file_has_a_unit_and_can_be_changed() -> None:
    parameter = with_integral().parameters["motor_1.servo_integral"]
    assert (parameter.value, parameter.unit) == (INTEGRAL, "Nm/(rad s)")
    assert "integral" not in servo_robot().spec.model_dump_json()
    placed = place_effects(servo_robot(), [parse_effect(f"servo_integral@motor_1:gain={INTEGRAL}", "test")])
    assert placed.robot.parameters["motor_1.servo_integral"].value == INTEGRAL


def test_more_than_the_nominal_integral_is_not_taken_away() -> None:
    with pytest.raises(InputError, match=r"-200.*integral of the servo is 150.*at least -150"):
        place_effects(with_integral(), [parse_effect("servo_integral@motor_1:gain=-200", "test")])


def test_other_programs_do_not_hold_it() -> None:
    robot = servo_robot(integral=INTEGRAL)
    not_held = repaired_numbers(PatchedRobot(robot, (), "test")).not_held
    assert [(one.name, one.size) for one in not_held] == [("servo integral", "150 Nm/(rad s)")]


def test_torque_of_a_log_has_its_part() -> None:
    """At rest the integral carries the weight; a held error makes it grow."""
    robot, position = with_integral(), np.full((200, 1), 0.7)
    parts = servo_parts(robot, position, position, T)
    np.testing.assert_allclose(parts.torque, robot.holding_torque(robot.equilibrium(motor_position=position[0]))[0])
    grown = servo_parts(robot, position + 0.1, position, T)
    np.testing.assert_allclose(grown.integral[-1] - grown.integral[0], 0.1 * INTEGRAL * 199 * T)


@pytest.mark.slow
@pytest.mark.parametrize("others", [(), ("coulomb_friction@motor_1:level=0.25",)])
def test_gain_is_found_in_a_log_of_positions(others: tuple[str, ...]) -> None:
    effects = (f"servo_integral@motor_1:gain={INTEGRAL}", *others)
    log, held = (checked_log(servo_log(*effects, seed=seed), servo_robot(), name="log") for seed in (0, 5))
    found = diagnose(log, servo_robot(), holdout=held, settings=settings_of(*SERVO_EFFECTS)).diagnosis.causes
    assert {f"{one.effect}@{one.location}" for one in found} == {text.partition(":")[0] for text in effects}
    gain = next(one for one in found if one.effect == "servo_integral").parameters["gain"]
    assert gain.std is not None
    assert abs(gain.value - INTEGRAL) < 4 * gain.std < 0.05 * INTEGRAL
