"""Hysteresis: closed loops of known area, the same at any speed, no energy from nowhere."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.stats import gamma

from flexros.arrays import FloatArray
from flexros.effects.gear.hysteresis import NODES, Hysteresis, slipping_angles
from flexros.robot import load_robot
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import GearLaw, halving_errors, laws_of, run, still

FOUR_MASS = load_robot("four_mass")
LEVEL, ANGLE = 5.0, 2e-3


def law(spread: float = 1.0) -> GearLaw:
    return GearLaw(Hysteresis(level=LEVEL, angle=ANGLE, spread=spread), stiffness=0.0)


def back_and_forth(amplitude: float, points: int, turns: int = 3) -> FloatArray:
    up, down = np.linspace(-amplitude, amplitude, points), np.linspace(amplitude, -amplitude, points)
    return np.concatenate([np.linspace(0.0, -amplitude, points), *([up, down] * turns)])


@pytest.mark.slow
@pytest.mark.parametrize("spread", [0.0, 1.0, 2.0])
def test_loops_are_the_same_at_any_speed_and_close(spread: float) -> None:
    slow, fast = law(spread).along(back_and_forth(5e-3, 201)), law(spread).along(back_and_forth(5e-3, 11))
    turns_slow = slow.reshape(7, 201)[1:]
    turns_fast = fast.reshape(7, 11)[1:]
    np.testing.assert_allclose(turns_slow[:, ::20], turns_fast, atol=1e-12)
    np.testing.assert_allclose(turns_slow[2:4], turns_slow[4:6], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_area_of_a_large_loop(spread: float) -> None:
    amplitude = 0.02
    path = back_and_forth(amplitude, 1001)
    torque = law(spread).along(path)
    last = slice(-2 * 1001, None)
    area = np.sum((torque[last][1:] + torque[last][:-1]) / 2 * np.diff(path[last]))
    angles = ca.DM(slipping_angles(ANGLE, spread)).full()
    assert np.max(angles) < amplitude
    assert area == pytest.approx(4 * LEVEL * (amplitude - np.mean(angles)), rel=1e-3)


def test_stiffness_after_a_reversal_and_level() -> None:
    path = np.array([0.05, 0.05 - 1e-6, -0.05])
    top, after, bottom = law().along(path)
    assert top == pytest.approx(LEVEL)
    assert bottom == pytest.approx(-LEVEL)
    assert (top - after) / 1e-6 == pytest.approx(LEVEL / ANGLE, rel=1e-6)


def test_first_loading_follows_the_exponential_of_dahl() -> None:
    path = np.linspace(0.0, 5 * ANGLE, 400)
    np.testing.assert_allclose(law().along(path), LEVEL * (1 - np.exp(-path / ANGLE)), atol=0.05 * LEVEL)


def test_without_spread_all_elements_slip_together() -> None:
    path = np.linspace(0.0, 2 * ANGLE, 9)
    np.testing.assert_allclose(law(0.0).along(path), np.minimum(path / ANGLE, 1.0) * LEVEL, atol=1e-12)


def test_nodes_cut_the_level_density_of_the_exponential_into_equal_parts() -> None:
    bounds = gamma(2).ppf(np.arange(7) / 6)
    stiffness = -np.diff(np.exp(-bounds))
    np.testing.assert_allclose(NODES, (1 / 6) / stiffness, atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_no_path_wins_energy(seed: int) -> None:
    path = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.3 * ANGLE, 400))
    fine = np.interp(np.linspace(0, len(path), 20 * len(path)), np.arange(len(path) + 1), np.concatenate([[0.0], path]))
    torque = law().along(fine)
    work = np.concatenate([[0.0], np.cumsum((torque[1:] + torque[:-1]) / 2 * np.diff(fine))])
    assert np.min(work) > -1e-3 * LEVEL * ANGLE


def test_swinging_robot_loses_energy() -> None:
    robot = FOUR_MASS.with_values(
        {name: 0.0 for name in FOUR_MASS.parameters if name.endswith(("damping", "viscous_friction"))}
    )
    start = np.zeros(8)
    start[3] = 0.03
    free = run(robot, (), 2000, still(robot), start)
    lossy = run(robot, laws_of(robot, "hysteresis@motor_1:level=0.05,angle=2e-3"), 2000, still(robot), start)

    def energy(path: FloatArray) -> FloatArray:
        return np.array(
            [sum(float(part) for part in robot.model.energy(x[:4], x[4:], np.zeros(0))) for x in path[::100]]
        )

    np.testing.assert_allclose(energy(free), energy(free)[0], rtol=1e-3)
    most = 0.05 * 2e-3  # what the elements can hold
    assert np.max(np.diff(energy(lossy))) < most
    assert energy(lossy)[-1] < 0.8 * energy(lossy)[0]


@pytest.mark.slow
def test_halving_the_step_converges() -> None:
    def waving(time: float) -> FloatArray:
        return np.array([3.0 * np.sin(20 * time)])

    hysteresis = laws_of(FOUR_MASS, "hysteresis@motor_1:level=0.3,angle=4e-3")
    errors = halving_errors(FOUR_MASS, hysteresis, 300, waving)
    effect = np.max(np.abs(run(FOUR_MASS, hysteresis, 300, waving) - run(FOUR_MASS, (), 300, waving))[:, :4])
    assert errors[0] < 1e-3 * effect
    assert errors[3] < errors[0] / 8


def test_level_of_zero_switches_it_off_and_a_loaded_robot_starts_unstretched() -> None:
    assert PlantModel(FOUR_MASS, laws_of(FOUR_MASS, "hysteresis@motor_1:level=0")).laws == ()
    elbow = load_robot("elbow")
    state = elbow.equilibrium(elbow.home)
    model = PlantModel(elbow, laws_of(elbow, "hysteresis@motor_2:level=50"))
    assert np.max(np.abs(model.rest(state).state - state)) < 1e-12
    rate = model.derivative(model.start(state), elbow.holding_torque(state), np.zeros(6), np.zeros(0))
    assert np.max(np.abs(rate.full())) < 1e-7
