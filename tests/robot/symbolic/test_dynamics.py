"""Laws of the equations of motion, and slow oracles for all built-in robots."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.robot import Robot, load_robot, robot_names
from tests.oracles.lagrange import arm_torque

pytestmark = pytest.mark.slow

pinocchio_model = pytest.importorskip("tests.oracles.pinocchio_model", reason="Pinocchio is not installed")


RIGID_LINKS = [name for name in robot_names() if not load_robot(name).chain.bends]
"""Pinocchio has no links that bend; tests/robot/symbolic/test_flexible_links.py checks those."""


@pytest.fixture(scope="module", params=RIGID_LINKS)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


def _random(robot: Robot, seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    n = robot.n_coordinates
    return 0.5 * rng.normal(size=n), rng.normal(size=n), rng.normal(size=robot.n_motors), rng.normal(size=6)


def test_mass_matrix_is_symmetric_and_positive(robot: Robot) -> None:
    M = np.asarray(robot.model.mass_matrix(_random(robot)[0], []))
    assert np.array_equal(M, M.T)
    assert np.linalg.eigvalsh(M)[0] > 0


def test_articulated_bodies_agree_with_the_mass_matrix(robot: Robot) -> None:
    q, v, u, w = _random(robot)
    a = np.asarray(robot.model.acceleration(q, v, u, w, [])).ravel()
    force = np.asarray(robot.model.force(q, v, u, w, [])).ravel()
    np.testing.assert_allclose(
        np.asarray(robot.model.mass_matrix(q, [])) @ a, force, rtol=1e-9, atol=1e-9 * np.abs(force).max()
    )


def test_inverse_dynamics_agrees_with_pinocchio(robot: Robot) -> None:
    import pinocchio as pin

    model = pinocchio_model.build(robot)
    q, v, *_ = _random(robot)
    N = robot.n_arm
    a = np.random.default_rng(5).normal(size=N)
    ours = np.asarray(robot.model.arm_inverse_dynamics(q[:N], v[:N], a, [])).ravel()
    friction = _body_friction(robot, q[:N], v[:N])
    theirs = pin.rnea(model, model.createData(), q[:N], v[:N], a)
    np.testing.assert_allclose(ours - friction, theirs, rtol=1e-11, atol=1e-11 * np.abs(theirs).max())


def _body_friction(robot: Robot, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Torque against the absolute rotation of the bodies; only planar built-in robots have it."""
    coefficients = np.array([body.viscous_friction.value for body in robot.spec.bodies])
    if not coefficients.any():
        return np.zeros(robot.n_arm)
    return np.cumsum((coefficients * np.cumsum(v))[::-1])[::-1]


def test_inertia_matrix_agrees_with_pinocchio(robot: Robot) -> None:
    import pinocchio as pin

    model = pinocchio_model.build(robot)
    q = _random(robot)[0][: robot.n_arm]
    theirs = pin.crba(model, model.createData(), q)
    theirs = np.triu(theirs) + np.triu(theirs, 1).T
    np.testing.assert_allclose(
        np.asarray(robot.model.arm_inertia(q, [])), theirs, rtol=1e-11, atol=1e-11 * np.abs(theirs).max()
    )


def test_tool_pose_agrees_with_pinocchio(robot: Robot) -> None:
    import pinocchio as pin

    if robot.spec.tool.linear is not None:
        assert robot.spec.tool.linear.component == "x"
        return  # a linear tool coordinate has no geometry; checked in test_one_axis
    model = pinocchio_model.build(robot)
    data = model.createData()
    q = _random(robot)[0][: robot.n_arm]
    pin.framesForwardKinematics(model, data, q)
    frame = data.oMf[model.getFrameId("tool")]
    pose = robot.tool_pose(q)
    np.testing.assert_allclose(pose[:3], frame.translation, atol=1e-12)
    quaternion = pin.Quaternion(frame.rotation).coeffs()
    np.testing.assert_allclose(abs(pose[3:] @ quaternion), 1, atol=1e-12)


def test_tool_wrench_does_the_work_of_the_tool_motion(robot: Robot) -> None:
    """The generalised force of a wrench is the transposed Jacobian of the tool, times the wrench."""
    import pinocchio as pin

    model = pinocchio_model.build(robot)
    q, v, u, w = _random(robot)
    N = robot.n_arm
    J = pin.computeFrameJacobian(model, model.createData(), q[:N], model.getFrameId("tool"), pin.LOCAL_WORLD_ALIGNED)
    zero = np.zeros(6)
    with_wrench, without = (np.asarray(robot.model.force(q, v, u, x, [])).ravel()[:N] for x in (w, zero))
    np.testing.assert_allclose(with_wrench - without, J.T @ w, atol=1e-9)


@pytest.mark.parametrize("name", ["e12", "elbow", "four_mass"])
def test_arm_obeys_lagrange(name: str) -> None:
    robot = load_robot(name)
    q, v, *_ = _random(robot)
    N = robot.n_arm
    a = np.random.default_rng(5).normal(size=N)
    ours = np.asarray(robot.model.arm_inverse_dynamics(q[:N], v[:N], a, [])).ravel() - _body_friction(robot, q, v[:N])
    np.testing.assert_allclose(ours, arm_torque(robot, q[:N], v[:N], a), rtol=1e-10, atol=1e-12)


def _without_losses(robot: Robot) -> Robot:
    losses = ("damping", "viscous_friction")
    return robot.with_values({name: 0.0 for name in robot.parameters if name.endswith(losses)})


@pytest.mark.parametrize("name", ["e12", "elbow", "four_mass", "six_axis"])
def test_energy_is_kept_without_dampers(name: str) -> None:
    robot = _without_losses(load_robot(name))
    n, model = robot.n_coordinates, robot.model
    start = robot.equilibrium(robot.home)
    start[n:] = 0.1 * np.random.default_rng(2).normal(size=n)
    u, w = np.zeros(robot.n_motors), np.zeros(6)

    def rate(_t: float, x: np.ndarray) -> np.ndarray:
        return np.asarray(model.derivative(x, u, w, [])).ravel()

    end = solve_ivp(rate, (0, 0.1), start, method="DOP853", rtol=1e-11, atol=1e-12, max_step=2e-3).y[:, -1]

    def total(x: np.ndarray) -> float:
        return sum(float(part) for part in model.energy(x[:n], x[n:], []))

    kinetic = float(model.energy(start[:n], start[n:], [])[0])
    assert abs(total(end) - total(start)) < 1e-6 * kinetic
    assert abs(float(model.energy(end[:n], end[n:], [])[0]) - kinetic) > 1e-3 * kinetic, (
        "energy must have been exchanged"
    )


def test_dampers_take_energy_away(robot: Robot) -> None:
    """The power of all forces that are no gradient of an energy is never positive."""
    q, v, *_ = _random(robot, 7)
    model, n = robot.model, robot.n_coordinates
    a = np.asarray(model.acceleration(q, v, np.zeros(robot.n_motors), np.zeros(6), [])).ravel()
    qs, vs = ca.SX.sym("q", n), ca.SX.sym("v", n)
    energy = sum(model.energy(qs, vs, []))
    power = ca.Function("power", [qs, vs], [ca.jtimes(energy, qs, vs) + ca.dot(ca.gradient(energy, vs), ca.DM(a))])
    assert float(power(q, v)) < 0


def test_state_derivative_agrees_with_differences_of_the_energy_free_motion(robot: Robot) -> None:
    """The Jacobian of the state derivative equals central differences."""
    q, v, u, w = _random(robot, 3)
    model, n = robot.model, robot.n_coordinates
    x = np.concatenate([q, v])
    symbol = ca.SX.sym("x", 2 * n)
    exact = np.asarray(ca.Function("A", [symbol], [ca.jacobian(model.derivative(symbol, u, w, []), symbol)])(x))
    step = 1e-6
    for index in range(0, 2 * n, max(1, n // 3)):
        shift = step * np.eye(2 * n)[index]
        high, low = (np.asarray(model.derivative(x + s, u, w, [])).ravel() for s in (shift, -shift))
        np.testing.assert_allclose((high - low) / (2 * step), exact[:, index], atol=1e-5 * np.abs(exact).max())


def test_free_parameter_gives_the_same_as_a_changed_robot(robot: Robot) -> None:
    names = ("body_1.mass", f"{robot.arm_names[-1]}.damping") if not robot.name.startswith("emps") else ("body_1.mass",)
    q, v, u, w = _random(robot)
    values = [1.5 * robot.parameters[name].value + 0.1 for name in names]
    free = robot.symbolic(names).acceleration(q, v, u, w, values)
    changed = robot.with_values(dict(zip(names, values))).model.acceleration(q, v, u, w, [])
    np.testing.assert_allclose(np.asarray(free), np.asarray(changed), rtol=1e-9, atol=1e-12)
