"""Bristles: they deflect like a spring, slide on the Stribeck curve, and only ever take energy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexros.arrays import FloatArray
from flexros.effects import effects, parse_effect, place_effects
from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.simulate.disturbance import Pulse
from flexros.simulate.plant import Plant
from tests.effects.single_mass import MASS, plant, states

pytestmark = pytest.mark.slow

LEVEL, EXTRA, VELOCITY, STIFFNESS, DAMPING = 20.0, 10.0, 0.05, 2e4, 500.0
NUMBERS = f"level={LEVEL},extra={EXTRA},velocity={VELOCITY},stiffness={STIFFNESS},damping={DAMPING}"
BRISTLES = f"presliding_friction@motor_1:{NUMBERS}"


def curve(speed: FloatArray | float) -> FloatArray | float:
    return LEVEL + EXTRA * np.exp(-((speed / VELOCITY) ** 2))


def lugre(
    force: float, start: tuple[float, float, float], times: FloatArray, ripple: float = 0.0, fading: float = np.inf
) -> FloatArray:
    """Integrate the equations as they stand; columns position, speed, deflection."""

    def rate(time: float, x: FloatArray) -> list[float]:
        _, v, z = x
        slip = v - STIFFNESS * abs(v) / curve(v) * z
        push = force + ripple * np.sin(20 * time)
        damping = DAMPING * np.exp(-((v / fading) ** 2))
        return [v, (push - STIFFNESS * z - damping * slip) / MASS, slip]

    solution = solve_ivp(rate, (0, times[-1]), start, "LSODA", times, rtol=1e-10, atol=1e-14, max_step=1e-3)
    result: FloatArray = solution.y.T
    return result


@pytest.mark.parametrize("speed", [0.02, 0.05, -0.5])
def test_steady_sliding_has_the_torque_of_the_stribeck_curve(speed: float) -> None:
    """A mass held on its speed by a strong damper gets, in the end, its damper's torque beyond the friction."""
    robot = load_robot("emps").with_values({"motor_1.viscous_friction": 1e5})
    force = 1e5 * speed + np.sign(speed) * curve(speed)
    path = states(plant(BRISTLES, start=(0.0, speed), robot=robot), 1200, lambda time: force)
    assert force - 1e5 * path[-1, 1] == pytest.approx(np.sign(speed) * curve(speed), rel=1e-4)


def test_below_break_away_the_mass_swings_on_the_bristles_and_stays() -> None:
    frequency = np.sqrt(STIFFNESS / MASS)
    path = states(plant(BRISTLES), 3000, lambda time: 1.0)
    assert path[-1, 0] == pytest.approx(1.0 / STIFFNESS, rel=0.12)  # the bristles creep
    assert np.ptp(path[-300:, 0]) < 3e-3 * path[-1, 0]
    peak = np.argmax(path[:, 0]) * 1e-3
    assert peak == pytest.approx(np.pi / frequency, rel=0.05)


@pytest.mark.parametrize(("force", "ripple"), [(0.0, 50.0), (15.0, 30.0)])
def test_motion_with_presliding_stops_and_reversals_is_that_of_the_equations(force: float, ripple: float) -> None:
    times = 1e-3 * np.arange(601)
    exact = lugre(force, (0.0, 0.0, 0.0), times, ripple)
    # the force is held through a sample, at its value in the middle
    path = states(plant(BRISTLES), 600, lambda time: force + ripple * np.sin(20 * (time + 5e-4)))
    assert np.any(np.diff(np.sign(exact[10:, 1])) != 0) or force > 0
    np.testing.assert_allclose(path, exact[:, :2], atol=2e-3 * np.max(np.abs(exact[:, :2]), axis=0).min())


def test_damping_that_fades_with_the_speed_is_that_of_the_equations() -> None:
    times, fading = 1e-3 * np.arange(601), 0.01
    exact, constant = (lugre(0.0, (0.0, 0.0, 0.0), times, 50.0, w)[:, :2] for w in (fading, np.inf))
    text = f"{BRISTLES},damping_velocity={fading}"
    path = states(plant(text), 600, lambda time: 50.0 * np.sin(20 * (time + 5e-4)))
    scale = np.max(np.abs(exact), axis=0)
    error, change = (np.max(np.abs(other - exact) / scale) for other in (path, constant))
    assert error < 0.1 * change


def test_stiff_bristles_are_dry_friction() -> None:
    def force(time: float) -> float:
        return 60.0 * np.sin(20 * time)

    stiff = states(plant("presliding_friction@motor_1:level=20,stiffness=1e10,damping=0"), 600, force)
    dry = states(plant("coulomb_friction@motor_1:level=20"), 600, force)
    np.testing.assert_allclose(stiff, dry, atol=2 * 20.0 / MASS * 1e-3)  # by less than a reversal moved by a step


@pytest.mark.parametrize("stiffness", [2e4, 2e6, 2e9])
def test_energy_of_mass_and_bristles_only_falls(stiffness: float) -> None:
    moving = plant(f"presliding_friction@motor_1:level=20,stiffness={stiffness},damping=100", start=(0.0, 0.1))
    path = states(moving, 1500)
    assert np.max(path[1:, 1] ** 2 - np.maximum.accumulate(path[:-1, 1] ** 2)) <= 0.0
    assert np.max(np.abs(path[-100:, 1])) < 0.03 * 0.1


def test_swinging_arm_on_bristles_loses_energy() -> None:
    robot = load_robot("two_mass").with_values({"body_1.rz.damping": 0.0})
    text = "presliding_friction@motor_1:level=20,stiffness=1e5,damping=50"
    path = states(plant(text, start=(8e-4, 0.0, 0.0, 0.0), robot=robot), 3000)
    energy = 3.0 * path[:, 2] ** 2 + 2.0 * path[:, 3] ** 2 + 3e4 * (path[:, 0] - path[:, 1]) ** 2
    assert energy[-1] < 0.9 * energy[0]
    assert np.max(energy) < 1.001 * energy[0]


def test_substeps_converge_with_order_two_through_presliding_and_sliding() -> None:
    robot = load_robot("two_mass")
    text = "presliding_friction@motor_1:level=100,extra=30,velocity=0.2,stiffness=1e5,damping=400"
    push = [Pulse(kind="pulse", at="motor_1", amplitude=a, start=s, width=0.1) for s, a in ((0.02, 90.0), (0.2, 300.0))]

    def path(substeps: int) -> FloatArray:
        laws = place_effects(robot, [parse_effect(text, "test")]).laws
        moving = Plant(robot, 1e-3, np.zeros(4), laws=laws, disturbances=push, substeps=substeps)
        return states(moving, 400)[:, 1]

    exact = path(128)
    errors = [float(np.max(np.abs(path(substeps) - exact))) for substeps in (1, 4, 16)]
    assert errors[0] < 2e-3 * np.max(np.abs(exact))
    assert np.log2(errors[0] / errors[2]) / 4 > 1.8


def test_bristles_need_a_stiffness() -> None:
    with pytest.raises(InputError, match=r"stiffness is 0, but must be positive; give stiffness=\.\.\. \[Nm/rad"):
        parse_effect("presliding_friction@motor_1:level=3", "--effect")


@pytest.mark.parametrize(
    "name", sorted(name for name, one in effects().items() if one.ranges.keys() >= {"stiffness", "damping", "level"})
)
def test_bristles_of_half_the_torque_bend_by_the_range_of_the_motion_at_most(name: str) -> None:
    """Bristles of 52 N/m had stood for a cable that pulled an axis by 18 N over a third of its stroke."""
    allowed = effects()[name].ranges["stiffness"]
    assert allowed.scale == "torque/angle"
    assert 0.5 / allowed.low <= 1.0
