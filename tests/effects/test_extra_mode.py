"""Extra modes: the frequencies of the coupled system, equal to robots with one body more."""

from __future__ import annotations

import copy
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import eigh

from flexros.arrays import FloatArray
from flexros.effects import parse_effect, place_effects
from flexros.effects.extra_mode import ExtraMode
from flexros.robot import Robot, load_robot
from flexros.robot.robot import robot_from_data
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import halving_errors, jacobian, laws_of, run

pytestmark = pytest.mark.slow

TWO_MASS, E12, ELBOW, FOUR_MASS = (load_robot(name) for name in ("two_mass", "e12", "elbow", "four_mass"))
W = 2 * np.pi * 8.0


def frequencies(slope: FloatArray) -> FloatArray:
    """Angular frequencies of the oscillations in a state matrix, ascending."""
    values = np.linalg.eigvals(slope)
    return np.sort(np.abs(values[values.imag > 1e-3]))


def with_body(robot: Robot, body: dict[str, Any], place: str) -> Robot:
    """Return the robot with one body more behind the last one or under the first one."""
    data = copy.deepcopy(robot.spec.model_dump())
    data["unknown_parameters"], data["inverse_kinematics"] = (), "numerical"
    n = sum(1 for axis in body["directions"])
    zeros = (0.0,) * n
    home = tuple(float(value) for value in robot.home)
    if place == "tool":
        data["bodies"], data["home"] = (*data["bodies"], body), (*home, *zeros)
    else:
        for output in data["outputs"].values():
            output["coordinates"] = ()
            output["pose"] = output["pose"] or ("x",)
        data["bodies"], data["home"] = (body, *data["bodies"]), (*zeros, *home)
    return robot_from_data(data, "test")


def test_two_masses_with_a_third_one_at_the_tool() -> None:
    robot = TWO_MASS.with_values({"body_1.rz.damping": 0.0})
    inertia = 0.3 * 6.0
    stiffness = inertia * W**2
    K = np.array([[6e4 + stiffness, -6e4, -stiffness], [-6e4, 6e4, 0.0], [-stiffness, 0.0, stiffness]])
    expected = np.sqrt(eigh(K, np.diag([6.0, 4.0, inertia]), eigvals_only=True)[1:])
    model = PlantModel(robot, laws_of(robot, "extra_mode@tool:frequency=8,ratio=0.3,damping=0"))
    np.testing.assert_allclose(frequencies(jacobian(model)), expected, rtol=1e-9)


def test_two_masses_on_a_flexible_base() -> None:
    robot = TWO_MASS.with_values({"body_1.rz.damping": 0.0})
    inertia = 0.5 * 6.0
    # coordinates: arm against the ground, motor against the base, base
    K = np.array([[6e4, -6e4, -6e4], [-6e4, 6e4, 6e4], [-6e4, 6e4, 6e4 + inertia * W**2]])
    expected = np.sqrt(eigh(K, np.diag([6.0, 4.0, inertia]), eigvals_only=True)[1:])
    model = PlantModel(robot, laws_of(robot, "extra_mode@base:frequency=8,ratio=0.5,damping=0"))
    np.testing.assert_allclose(frequencies(jacobian(model)), expected, rtol=1e-9)


@pytest.mark.parametrize("name", ["two_mass", "e12", "six_axis"])
def test_light_mode_has_its_frequency_and_damping(name: str) -> None:
    robot = load_robot(name)
    model = PlantModel(robot, laws_of(robot, "extra_mode@tool:frequency=8,ratio=1e-9,damping=0.03"))
    own = slice(2 * robot.n_coordinates, None)
    values = np.linalg.eigvals(jacobian(model)[own, own])
    mode = values[np.abs(values) > 1.0]  # three directions of a mass, one rotation
    np.testing.assert_allclose(np.abs(mode), W, rtol=1e-9)
    np.testing.assert_allclose(-mode.real, 0.03 * W, rtol=1e-9)
    assert len(mode) == (2 if name == "two_mass" else 8)


def test_point_mass_at_the_tool_equals_a_robot_with_one_body_more() -> None:
    mass = 0.2 * 200.0
    spring = {"spring": mass * W**2}
    longer = with_body(E12, {"mass": mass, "directions": {"tx": spring, "tz": spring}}, "tool")
    law = laws_of(E12, "extra_mode@tool:frequency=8,ratio=0.2,damping=0")

    def pushed(time: float) -> FloatArray:
        return np.array([3000.0, -2000.0]) * np.sin(9 * time)

    start = np.array([0.0, 0.3, 0.0, 0.0, 0.3, *[0.0] * 5])
    ours = run(E12, law, 400, pushed, start)
    theirs = run(longer, (), 400, pushed, np.array([0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.3, *[0.0] * 7]))
    assert np.max(np.abs(ours[:, 0] - ours[0, 0])) > 0.05
    np.testing.assert_allclose(ours[:, :3], theirs[:, :3], atol=2e-8)
    np.testing.assert_allclose(ours[:, 3:5], theirs[:, 5:7], atol=2e-8)
    assert np.max(np.abs(ours - run(E12, (), 400, pushed, start))[:, :5]) > 1e-4


def test_turning_inertia_at_the_tool_equals_a_robot_with_one_body_more() -> None:
    inertia = 0.3 * 50.0
    spring = {"spring": inertia * W**2, "damper": 2 * 0.05 * inertia * W}
    longer = with_body(E12, {"inertia": {"yy": inertia}, "directions": {"ry": spring}}, "tool")
    law = laws_of(E12, "extra_mode@tool:frequency=8,inertia_ratio=0.3,damping=0.05")

    def pushed(time: float) -> FloatArray:
        return np.array([3000.0, -2000.0]) * np.sin(9 * time)

    start = np.array([0.0, 0.3, 0.0, 0.0, 0.3, *[0.0] * 5])
    ours = run(E12, law, 400, pushed, start)
    theirs = run(longer, (), 400, pushed, np.array([0.0, 0.3, 0.0, 0.0, 0.0, 0.3, *[0.0] * 6]))
    np.testing.assert_allclose(ours[:, :3], theirs[:, :3], atol=2e-8)
    np.testing.assert_allclose(ours[:, 3:5], theirs[:, 4:6], atol=2e-8)
    assert np.max(np.abs(ours - run(E12, (), 400, pushed, start))[:, :5]) > 1e-4


def test_only_parameters_that_act_at_a_location_are_fitted() -> None:
    assert "inertia_ratio" in ExtraMode().fitted(E12, "tool")
    for robot, place in ((E12, "base"), (FOUR_MASS, "tool"), (load_robot("emps"), "tool")):
        assert list(ExtraMode().fitted(robot, place)) == ["frequency", "ratio", "damping"]


@pytest.mark.parametrize("robot", [E12, ELBOW], ids=["e12", "elbow under gravity"])
def test_flexible_base_equals_a_robot_with_one_body_more(robot: Robot) -> None:
    arm = float(np.asarray(robot.model.arm_inertia(robot.home, np.zeros(0)))[0, 0])
    inertia = 0.4 * arm
    spring = {"spring": inertia * W**2, "damper": 2 * 0.05 * inertia * W}
    longer = with_body(robot, {"inertia": {"yy": inertia}, "directions": {"ry": spring}}, "base")
    law = laws_of(robot, "extra_mode@base:frequency=8,ratio=0.4,damping=0.05")
    n, motors = robot.n_arm, robot.equilibrium(robot.home)[robot.n_arm : robot.n_coordinates]
    at_rest = longer.equilibrium(np.array([0.0, *robot.home]), motor_position=motors)
    model = PlantModel(robot, law)
    rest = model.rest(robot.equilibrium(robot.home))
    hold = longer.holding_torque(at_rest)
    np.testing.assert_allclose(rest.torque, hold, atol=1e-6 * (1 + np.max(np.abs(hold))))

    def pushed(time: float) -> FloatArray:
        return hold + 2000.0 * np.sin(9 * time) * np.array([1.0, -0.4])

    ours, theirs = run(robot, law, 400, pushed, rest.state), run(longer, (), 400, pushed, at_rest)
    np.testing.assert_allclose(ours[:, 0], theirs[:, 0] + theirs[:, 1], atol=2e-8)
    np.testing.assert_allclose(ours[:, 1 : robot.n_coordinates], theirs[:, 2 : robot.n_coordinates + 1], atol=2e-8)
    assert np.max(np.abs(theirs[:, 0] - theirs[0, 0])) > 1e-4
    assert n == 3 or abs(at_rest[0]) > 1e-5  # the base of the elbow gives way under gravity


@pytest.mark.parametrize("place", ["tool", "base"])
def test_halving_the_step_converges(place: str) -> None:
    def waving(time: float) -> FloatArray:
        return np.array([100.0 * np.sin(20 * time)])

    errors = halving_errors(TWO_MASS, laws_of(TWO_MASS, f"extra_mode@{place}:frequency=12,ratio=0.5"), 300, waving)
    assert errors[0] < 1e-6
    assert errors[1] < errors[0] / 12


def test_parameters_may_be_free() -> None:
    laws = laws_of(
        E12,
        "extra_mode@base:frequency=8,ratio=0.4",
        "extra_mode@tool:frequency=5,ratio=0.1,inertia_ratio=0.2,damping=0.1",
    )
    fixed = PlantModel(E12, laws)
    names = [name for law in laws for name in law.parameters]
    free = PlantModel(E12, laws, [*names, "body_3.mass", "body_1.ry.stiffness"])
    x = np.random.default_rng(1).normal(size=fixed.n_states)
    arguments = (np.ones(2), np.zeros(6))
    values = [8.0, 0.4, 0.0, 0.02, 5.0, 0.1, 0.2, 0.1, 200.0, 1e5]
    np.testing.assert_allclose(
        free.derivative(x, *arguments, values).full(), fixed.derivative(x, *arguments, ca.DM(0, 1)).full(), rtol=1e-9
    )


def test_locations_and_neutral_value() -> None:
    effect = ExtraMode()
    assert PlantModel(E12, laws_of(E12, "extra_mode@tool:ratio=0")).laws == ()
    assert effect.locations(load_robot("emps")) == ("tool",)
    assert effect.locations(FOUR_MASS) == ("tool", "base")
    assert effect.locations(load_robot("six_axis")) == ("tool", "base")


def test_part_of_the_known_mass_is_a_mode_with_a_lighter_load() -> None:
    """A drive whose mass is right, with a tenth of it on a spring."""
    drive, share = load_robot("emps"), 0.1
    mass = drive.parameters["body_1.mass"].value
    body = {"mass": share * mass, "directions": {"tx": {"spring": share * mass * W**2}}}
    longer = with_body(drive.with_values({"body_1.mass": (1 - share) * mass}), body, "tool")
    mode = f"extra_mode@tool:frequency=8,ratio={share / (1 - share)},damping=0"
    texts = (f"payload_error@tool:relative={-share}", mode)
    ours = place_effects(drive, [parse_effect(text, "test") for text in texts])

    def pushed(time: float) -> FloatArray:
        return np.array([100.0 * np.sin(9 * time)])

    moved = run(ours.robot, ours.laws, 400, pushed)
    np.testing.assert_allclose(moved[:, 0], run(longer, (), 400, pushed)[:, 0], atol=1e-9)
    assert np.max(np.abs(moved - run(drive, (), 400, pushed))[:, 0]) > 1e-5


def test_mass_moves_along_where_a_run_begins_in_motion() -> None:
    drive = load_robot("emps").with_values({"motor_1.viscous_friction": 0.0})
    law = laws_of(drive, "extra_mode@tool:frequency=8,ratio=0.5")
    moved = run(drive, law, 200, lambda time: np.zeros(1), np.array([0.0, 0.1]))
    np.testing.assert_allclose(moved[:, 1], 0.1, rtol=1e-12)
