from __future__ import annotations

from dataclasses import replace

import cvxpy as cp
import numpy as np
import pytest
from scipy.optimize import brentq

from flexros.errors import InputError
from flexros.feedforward.arm_on_path import FeedforwardOnPath
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.robot import load_robot
from flexros.trajectory.line import JointMove
from flexros.trajectory.time_optimal.path_dynamics import PathDynamics, path_grid
from flexros.trajectory.time_optimal.profile import fastest_profile

WAY, MASS, FORCE = 2.0, 3.0, 12.0


def carriage(
    points: int = 401, *, weight: float = 0.0, damping: float = 0.0, speed: float = np.inf, force: float = FORCE
) -> PathDynamics:
    """Return a mass on a straight way."""
    one = np.ones((points, 1))
    return PathDynamics(
        grid=path_grid(points),
        slope=WAY * one,
        inertia=MASS * WAY * one,
        centrifugal=0.0 * one,
        viscous=damping * WAY * one,
        static=weight * one,
        lower=-force * one,
        upper=force * one,
        speed_limit=np.array([speed]),
        names=("motor_1",),
    )


def two_axes(points: int = 201, **values: float) -> PathDynamics:
    """Return the elbow on a joint move, without viscous friction unless given."""
    free = {"motor_1.viscous_friction": 0.0, "motor_2.viscous_friction": 0.0}
    robot = load_robot("elbow").with_values({**free, **values})
    path = JointMove(robot.home[list(robot.gear_rows)], np.array([1.1, -0.7]))
    rigid = FeedforwardSpecification(method="rigid")
    return FeedforwardOnPath(robot, rigid, robot.sample_time, "joints").dynamics(path, None, points)


def test_double_integrator_is_bang_bang() -> None:
    profile = fastest_profile(carriage())
    assert profile.duration == pytest.approx(2.0 * np.sqrt(WAY * MASS / FORCE), rel=1e-5)


def test_speed_limit_gives_a_trapezoid() -> None:
    speed, most = 1.5, FORCE / MASS
    profile = fastest_profile(carriage(speed=speed))
    assert profile.duration == pytest.approx(WAY / speed + speed / most, rel=1e-5)
    assert WAY * np.sqrt(profile.squared_pace.max()) == pytest.approx(speed)


def test_weight_makes_it_asymmetric() -> None:
    weight = 5.0
    up, down = (FORCE - weight) / MASS, (FORCE + weight) / MASS
    profile = fastest_profile(carriage(weight=weight))
    assert profile.duration == pytest.approx(np.sqrt(2.0 * WAY * (1.0 / up + 1.0 / down)), rel=1e-5)


def test_viscous_friction_brakes() -> None:
    damping = 4.0
    rate, top = damping / MASS, FORCE / damping

    def rest(switch: float) -> tuple[float, float]:
        """Return time and way until rest for a switch of the force at a time."""
        speed = top * (1.0 - np.exp(-rate * switch))
        way = top * (switch - (1.0 - np.exp(-rate * switch)) / rate)
        braking = np.log(1.0 + speed / top) / rate
        return switch + braking, way + speed / rate - top * braking

    switch = brentq(lambda time: rest(time)[1] - WAY, 0.1, 5.0)
    exact = rest(switch)[0]
    coarse, fine = (fastest_profile(carriage(points, damping=damping)).duration / exact - 1.0 for points in (201, 801))
    assert 0.0 < fine < 6e-4, "limits that hold on both sides of each point are never faster than the optimum"
    assert fine < 0.35 * coarse


def test_two_axes_reach_the_optimum_of_a_convex_program() -> None:
    """Minimum of the time over x = sigma'^2 with all limits at once (Verscheure et al. 2009), by another solver."""
    dynamics = two_axes()
    step = np.diff(dynamics.grid)
    x = cp.Variable(dynamics.grid.size, nonneg=True)
    u = cp.multiply(cp.diff(x), 0.5 / step)
    limits = []
    for rows in (slice(None, -1), slice(1, None)):
        for motor in range(2):
            limit = dynamics.upper[0, motor]
            load = dynamics.static[rows, motor] / limit
            share = cp.multiply(dynamics.inertia[rows, motor] / limit, u) + load
            share += cp.multiply(dynamics.centrifugal[rows, motor] / limit, x[rows])
            limits += [share <= 1.0, share >= -1.0]
    root = cp.sqrt(x)
    time = cp.sum(cp.multiply(cp.inv_pos(root[1:] + root[:-1]), 2.0 * step))
    problem = cp.Problem(cp.Minimize(time), [*limits, x[0] == 0, x[-1] == 0])
    problem.solve(solver=cp.CLARABEL)
    assert fastest_profile(dynamics).duration == pytest.approx(problem.value, rel=1e-5)


@pytest.mark.parametrize("viscous", [0.0, 60.0])
def test_some_limit_is_active_everywhere_and_none_is_exceeded(viscous: float) -> None:
    dynamics = two_axes(points=401, **{"motor_1.viscous_friction": viscous})
    use = fastest_profile(dynamics).use(dynamics).max(axis=1)
    assert use.max() < 1.0 + 1e-4
    idle = use < 1.0 - 1e-3
    assert idle.mean() < 0.02, "only where the torque changes from one limit to another"
    assert not np.any(idle[1:] & idle[:-1])


def test_backwards_a_weight_helps_and_the_time_is_that_of_the_way_back() -> None:
    dynamics = replace(carriage(weight=5.0), static=np.linspace(0.0, 8.0, 401)[:, None])
    there, back = fastest_profile(dynamics), fastest_profile(dynamics.backwards())
    assert back.duration == pytest.approx(there.duration, rel=1e-6)
    np.testing.assert_allclose(back.squared_pace, there.squared_pace[::-1], rtol=0.05, atol=0.02)


def test_arm_that_cannot_be_held_is_refused() -> None:
    with pytest.raises(InputError, match="motor_1 needs 15 to hold"):
        fastest_profile(carriage(weight=15.0))


def test_motion_without_limits_is_refused() -> None:
    with pytest.raises(InputError, match="neither torque nor speed"):
        fastest_profile(carriage(force=np.inf))
