"""Nonlinear stiffness follows its law, conserves energy and carries gravity at the start."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import PlacedLaw, parse_effect, place_effects
from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.robot.spring import Cubic, Spring
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import halving_errors


def robot_with(robot: Robot, *texts: str) -> Robot:
    return place_effects(robot, [parse_effect(text, "test") for text in texts]).robot


def spring_torque(robot: Robot, name: str, deflection: float) -> float:
    spring = next(joint.direction.spring for joint in robot.joints if joint.name == name)
    assert isinstance(spring, Spring)
    return float(ca.DM(spring.force(ca.SX(deflection), robot.parameters[f"{name}.stiffness"].value)))


@pytest.mark.parametrize("relative", [0.5, -0.5])
def test_law_of_a_linear_spring(relative: float) -> None:
    robot = robot_with(load_robot("two_mass"), f"nonlinear_stiffness@body_1.rz:relative={relative},knee=0.002")
    for deflection in (0.0, 0.001, 0.002, 0.003, 0.01):
        torque = 6e4 * (deflection + relative * max(deflection - 0.002, 0.0))
        assert spring_torque(robot, "body_1.rz", deflection) == pytest.approx(torque, rel=1e-12)
        assert spring_torque(robot, "body_1.rz", -deflection) == pytest.approx(-torque, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("knee", [0.01, 0.032, 0.04, 0.1])
def test_law_of_a_spring_with_knees_of_its_own(knee: float) -> None:
    before = load_robot("four_mass")
    after = robot_with(before, f"nonlinear_stiffness@body_1.rz:relative=0.3,knee={knee}")
    at_knee = spring_torque(before, "body_1.rz", knee)
    for deflection in np.linspace(0.0, 0.15, 31):
        plain = spring_torque(before, "body_1.rz", deflection)
        expected = plain + 0.3 * max(plain - at_knee, 0.0)
        assert spring_torque(after, "body_1.rz", deflection) == pytest.approx(expected, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(("robot_name", "knee_torque"), [("two_mass", 90.0), ("four_mass", 0.5), ("four_mass", 5.0)])
def test_knee_may_be_given_as_a_torque(robot_name: str, knee_torque: float) -> None:
    robot = load_robot(robot_name)
    bent = robot_with(robot, f"nonlinear_stiffness@body_1.rz:relative=0.5,knee_torque={knee_torque}")
    low, high = 0.0, 1.0
    for _ in range(60):  # deflection at which the unbent spring reaches the torque
        middle = (low + high) / 2
        low, high = (middle, high) if spring_torque(robot, "body_1.rz", middle) < knee_torque else (low, middle)
    assert spring_torque(bent, "body_1.rz", low) == pytest.approx(knee_torque, rel=1e-9)
    slope = (spring_torque(bent, "body_1.rz", low + 1e-6) - spring_torque(bent, "body_1.rz", low)) / 1e-6
    before = (spring_torque(robot, "body_1.rz", low + 1e-6) - spring_torque(robot, "body_1.rz", low)) / 1e-6
    assert slope == pytest.approx(1.5 * before, rel=1e-4)


def test_energy_of_an_undamped_robot_is_conserved() -> None:
    robot = load_robot("two_mass").with_values({"body_1.rz.damping": 0.0})
    robot = robot_with(robot, "nonlinear_stiffness@body_1.rz:relative=1,knee=0.002")
    plant = Plant(robot, 1e-3, np.array([0.01, 0.0, 0.0, 0.0]), substeps=8)
    energies = []
    for _ in range(500):
        q, v = np.split(plant.state, 2)
        energies.append(sum(float(part) for part in robot.model.energy(q, v, robot.model.parameter_values)))
        plant.advance([0.0])
    assert energies[0] == pytest.approx(3e4 * (0.01**2 + 0.008**2))
    np.testing.assert_allclose(energies, energies[0], rtol=1e-4)  # a step across the knee is of order two


@pytest.mark.slow
def test_rest_under_gravity_includes_the_knees_of_gear_and_arm_springs() -> None:
    robot = load_robot("six_axis")
    texts = (
        "nonlinear_stiffness@body_3.ry:relative=0.6,knee=1e-4",
        "nonlinear_stiffness@body_2.ry:relative=-0.4,knee=1e-5",
    )
    bent = robot_with(robot, *texts)
    state = bent.equilibrium(robot.home, motor_position=robot.equilibrium(robot.home)[list(robot.motor_rows)])
    rate = bent.model.derivative(state, bent.holding_torque(state), np.zeros(6), ca.DM(0, 1))
    np.testing.assert_allclose(rate.full(), 0.0, atol=1e-7)
    places = {joint.name: index for index, joint in enumerate(robot.joints)}
    lower_arm = state[robot.motor_rows[1]] - state[places["body_3.ry"]]
    assert abs(lower_arm) > 1e-4
    assert abs(state[places["body_2.ry"]]) > 1e-5
    assert bent.holding_torque(state)[1] == pytest.approx(spring_torque(bent, "body_3.ry", lower_arm), rel=1e-6)


def test_other_effects_act_on_the_bent_spring() -> None:
    robot = robot_with(
        load_robot("two_mass"),
        "nonlinear_stiffness@body_1.rz:relative=1,knee=0.001",
        "stiffness_error@body_1.rz:relative=0.1",
    )
    assert spring_torque(robot, "body_1.rz", 0.002) == pytest.approx(1.1 * 6e4 * 0.003)


def test_cubic_springs_are_no_location() -> None:
    data = load_robot("two_mass").spec.model_copy(deep=True)
    body = data.bodies[0]
    cubic = Spring(cubic=Cubic(linear=1e4, cubic=1e7))
    bent = body.model_copy(update={"directions": {"rz": body.directions["rz"].model_copy(update={"spring": cubic})}})
    robot = Robot(data.model_copy(update={"bodies": (bent,)}), "test")
    with pytest.raises(InputError, match="location of nonlinear_stiffness on robot two_mass"):
        robot_with(robot, "nonlinear_stiffness@body_1.rz:relative=1,knee=0.001")


@pytest.mark.parametrize("parameters", ["relative=0.5", "relative=0.5,knee=0.1,knee_torque=3"])
def test_one_knee_must_be_given(parameters: str) -> None:
    with pytest.raises(InputError, match=r"knee is .* and knee_torque .*, but one of the two must be above zero"):
        parse_effect(f"nonlinear_stiffness@body_1.rz:{parameters}", "--effect")


def test_torque_that_is_never_reached_is_refused() -> None:
    data = load_robot("four_mass").spec.model_dump()
    law = data["bodies"][0]["directions"]["rz"]["spring"]["piecewise_linear"]
    law["slopes"] = (*law["slopes"][:-1], 0.0)
    robot = Robot(type(load_robot("four_mass").spec).model_validate(data), "test")
    with pytest.raises(
        InputError, match=r"knee_torque is 1000, but the spring never reaches it; lower it or give knee"
    ):
        robot_with(robot, "nonlinear_stiffness@body_1.rz:relative=1,knee_torque=1000")


def as_law(robot: Robot, *texts: str) -> tuple[PlacedLaw, ...]:
    placed = place_effects(robot, [parse_effect(text, "test") for text in texts], as_laws=True)
    assert placed.robot is robot
    return placed.laws


def controlled(robot: Robot, laws: tuple[PlacedLaw, ...], gain: float, push: float, near: FloatArray) -> FloatArray:
    """Move the motors to and fro in closed loop, from a rest near a state; return the states of all samples."""
    rest = PlantModel(robot, laws).rest(near)
    plant = Plant(robot, robot.sample_time, rest.state, laws=laws)
    hold, before = rest.torque, plant.measure()
    goal, rows = before.copy(), []
    for k in range(400):
        reading = plant.measure()
        target = goal + push / gain * np.sin(30 * k * robot.sample_time)
        plant.advance(hold + gain * (target - reading) - 0.02 * gain * (reading - before) / robot.sample_time)
        before = reading
        rows.append(plant.state)
    return np.array(rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "effect", "gain", "push"),
    [
        ("two_mass", "nonlinear_stiffness@body_1.rz:relative=0.8,knee=1e-3", 3e4, 1000.0),
        ("two_mass", "nonlinear_stiffness@body_1.rz:relative=-0.5,knee_torque=40", 3e4, 1000.0),
        ("four_mass", "nonlinear_stiffness@body_1.rz:relative=0.6,knee=0.02", 20.0, 5.0),
        ("four_mass", "nonlinear_stiffness@body_1.rz:relative=0.6,knee_torque=0.5", 20.0, 5.0),
        ("e12", "nonlinear_stiffness@body_3.ry:relative=0.5,knee=1e-3", 1e5, 2e4),
        ("six_axis", "nonlinear_stiffness@body_3.ry:relative=0.6,knee=1e-4", 1e5, 3e3),
    ],
)
def test_parallel_law_equals_the_nonlinear_spring_in_closed_loop(
    name: str, effect: str, gain: float, push: float
) -> None:
    robot = load_robot(name)
    near, nq = robot.equilibrium(robot.home), robot.n_coordinates
    law = controlled(robot, as_law(robot, effect), gain, push, near)
    bent = controlled(robot_with(robot, effect), (), gain, push, near)
    assert np.max(np.abs(bent - controlled(robot, (), gain, push, near))[:, :nq]) > 1e-6
    np.testing.assert_allclose(law[:, :nq], bent[:, :nq], atol=1e-9)


def test_halving_the_step_converges() -> None:
    robot = load_robot("two_mass")
    law = as_law(robot, "nonlinear_stiffness@body_1.rz:relative=1,knee=5e-4")
    errors = halving_errors(robot, law, 300, lambda time: np.array([150.0 * np.sin(20 * time)]))
    assert errors[0] < 1e-5
    assert errors[3] < errors[0] / 20


def test_neutral_law_is_omitted() -> None:
    robot = load_robot("two_mass")
    assert PlantModel(robot, as_law(robot, "nonlinear_stiffness@body_1.rz:relative=0,knee=1e-3")).laws == ()


def test_stiffness_changes_linearly_around_a_rounded_corner_and_is_nominal_before() -> None:
    robot = load_robot("two_mass")
    bent = robot_with(robot, "nonlinear_stiffness@body_1.rz:relative=0.5,knee=0.002,rounding=0.3")
    deflections = np.linspace(0, 0.006, 301)
    torques = np.array([spring_torque(bent, "body_1.rz", deflection) for deflection in deflections])
    stiffness = np.interp(deflections, [0.7 * 0.002, 1.3 * 0.002], [6e4, 9e4])
    expected = np.concatenate([[0.0], np.cumsum((stiffness[1:] + stiffness[:-1]) / 2) * deflections[1]])
    assert torques == pytest.approx(expected, rel=5e-3, abs=1e-9)
    below = deflections < 0.7 * 0.002
    assert torques[below] == pytest.approx(6e4 * deflections[below], rel=1e-12)
    assert spring_torque(bent, "body_1.rz", -0.004) == -spring_torque(bent, "body_1.rz", 0.004)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "effect", "gain", "push"),
    [
        ("two_mass", "nonlinear_stiffness@body_1.rz:relative=0.8,knee=1e-3,rounding=0.5", 3e4, 1000.0),
        ("four_mass", "nonlinear_stiffness@body_1.rz:relative=0.6,knee_torque=0.5,rounding=2", 20.0, 5.0),
    ],
)
def test_a_rounded_corner_is_nearly_a_polygon_in_the_file(name: str, effect: str, gain: float, push: float) -> None:
    robot = load_robot(name)
    near, nq = robot.equilibrium(robot.home), robot.n_coordinates
    law = controlled(robot, as_law(robot, effect), gain, push, near)[:, :nq]
    polygon = controlled(robot_with(robot, effect), (), gain, push, near)[:, :nq]
    sharp = controlled(robot_with(robot, effect.rsplit(",", 1)[0]), (), gain, push, near)[:, :nq]
    assert np.max(np.abs(law - polygon)) < 0.05 * np.max(np.abs(law - sharp))
