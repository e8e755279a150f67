"""Filters of commanded positions: law, rest, and their time constant from a log of positions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.arrays import FloatArray
from flexros.effects import parse_effect, place_effects
from flexros.gap.candidates.candidate import list_candidates
from flexros.gap.candidates.scales import Scales
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import SERVO_EFFECTS, T, servo_log, servo_robot

LAG = 0.03
INERTIA, VISCOUS, WEIGHT = 0.05 + 0.02 + 1.5 * 0.2**2, 0.3, 1.5 * 9.81 * 0.2


def angles(effect: str, samples: int, substeps: int = 4, commands: str = "position") -> FloatArray:
    """Angles after a step of the command from 0, where the joint is upright without load."""
    robot = servo_robot().commanded_by(commands)  # type: ignore[arg-type]
    placed = place_effects(robot, [parse_effect(text, "test") for text in effect.split()])
    plant = Plant(placed.robot, T, np.zeros(2), torque=np.zeros(1), substeps=substeps, laws=placed.laws)
    found = []
    for _ in range(samples):
        found.append(plant.state[0])
        plant.advance([0.3])
    return np.array(found)


def test_joint_follows_the_filtered_step() -> None:
    def slope(time: float, x: FloatArray) -> list[float]:
        followed = 0.3 * (1 - np.exp(-time / LAG))
        torque = 60.0 * (followed - x[0]) - 2.0 * x[1]
        return [x[1], (torque - VISCOUS * x[1] + WEIGHT * np.sin(x[0])) / INERTIA]

    times = T * np.arange(200)
    exact = solve_ivp(slope, (0.0, times[-1]), [0.0, 0.0], t_eval=times, rtol=1e-10, atol=1e-12).y[0]
    np.testing.assert_allclose(angles(f"servo_command_lag@motor_1:time_constant={LAG}", 200), exact, atol=1e-7)
    assert np.max(np.abs(angles("servo_command_lag@motor_1:time_constant=0", 200) - exact)) > 0.01


def test_substeps_converge_with_order_four() -> None:
    effect = f"servo_command_lag@motor_1:time_constant={LAG}"
    fine = angles(effect, 100, 64)
    errors = [np.max(np.abs(angles(effect, 100, substeps) - fine)) for substeps in (1, 2, 4)]
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 3.5)


def test_torques_are_not_filtered_and_zero_is_neutral() -> None:
    effect = f"servo_command_lag@motor_1:time_constant={LAG}"
    assert np.array_equal(angles(effect, 50, commands="torque"), angles("", 50, commands="torque"))
    assert np.array_equal(angles("servo_command_lag@motor_1:time_constant=0", 50), angles("", 50))


def test_robot_at_rest_stays_there() -> None:
    placed = place_effects(
        servo_robot().commanded_by("position"), [parse_effect("servo_command_lag@motor_1:time_constant=0.03", "test")]
    )
    model, state = PlantModel(placed.robot, placed.laws), placed.robot.equilibrium(motor_position=np.array([0.7]))
    command = model.command_at_rest(state, placed.robot.holding_torque(state), np.zeros(0))
    plant = Plant(placed.robot, T, state, torque=command, laws=placed.laws)
    for _ in range(100):
        plant.advance(command)
    np.testing.assert_allclose(plant.state, state, atol=1e-12)


def test_it_is_sought_where_positions_are_commanded() -> None:
    for commands, sought in (("position", True), ("torque", False)):
        robot = servo_robot().commanded_by(commands)  # type: ignore[arg-type]
        assert ("servo_command_lag" in {one.effect.name for one in list_candidates(robot, Scales({}))}) == sought


@pytest.mark.slow
@pytest.mark.parametrize("others", [(), ("delay@all:time=0.006",)])
def test_time_constant_is_found_in_a_log_of_positions(others: tuple[str, ...]) -> None:
    effects = (f"servo_command_lag@motor_1:time_constant={LAG}", *others)
    log, held = (checked_log(servo_log(*effects, seed=seed), servo_robot(), name="log") for seed in (0, 5))
    found = diagnose(log, servo_robot(), holdout=held, settings=settings_of(*SERVO_EFFECTS)).diagnosis.causes
    assert {f"{one.effect}@{one.location}" for one in found} == {text.partition(":")[0] for text in effects}
    constant = next(one for one in found if one.effect == "servo_command_lag").parameters["time_constant"]
    assert constant.std is not None
    assert abs(constant.value - LAG) < 4 * constant.std < 0.1 * LAG
