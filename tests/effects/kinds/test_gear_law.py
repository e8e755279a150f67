"""Several laws of one spring: each acts on what those before it have made of the spring."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import parse_effect, place_effects
from flexros.robot import Robot, load_robot
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import laws_of, run

TWO_MASS = load_robot("two_mass")
PLAY, WAVE = "backlash@motor_1:gap=0.02", "transmission_error@motor_1:amplitude=3e-3,order=5,phase=1"
BENT, LOSS = "nonlinear_stiffness@body_1.rz:relative=1,knee=1e-3", "hysteresis@motor_1:level=20,angle=1e-3"


def motor_torque(*texts: str, motor: float, speed: float = 0.0) -> float:
    """Return the torque from motor to arm with the arm at zero, read off its acceleration."""
    laws = place_effects(TWO_MASS, [parse_effect(text, "test") for text in texts], as_laws=True).laws
    model = PlantModel(TWO_MASS, laws)
    state = model.start(np.array([0.0, motor, 0.0, 0.0]))
    state[3] = speed
    rate = model.derivative(state, np.zeros(1), np.zeros(6), ca.DM(0, 1))
    return 6.0 * float(rate[2])


def wave(motor: float) -> float:
    return 3e-3 * np.sin(5 * motor + 1)


@pytest.mark.parametrize("order", [(PLAY, WAVE), (WAVE, PLAY)])
def test_gap_counts_from_the_shifted_deflection(order: tuple[str, str]) -> None:
    for motor in (-0.02, -0.012, -0.005, 0.0, 0.007, 0.0085, 0.02):
        deflection = motor + wave(motor)
        expected = 6e4 * (max(deflection - 0.01, 0.0) + min(deflection + 0.01, 0.0))
        assert motor_torque(*order, motor=motor) == pytest.approx(expected, abs=1e-8)


def test_nonlinear_spring_acts_after_the_gap() -> None:
    for motor, twist in ((0.0105, 0.0005), (0.013, 0.003), (-0.014, -0.004)):
        torque = 6e4 * (twist + np.sign(twist) * max(abs(twist) - 1e-3, 0.0))
        assert motor_torque(PLAY, BENT, motor=motor) == pytest.approx(torque, rel=1e-9)
        assert motor_torque(BENT, PLAY, motor=motor) == pytest.approx(torque, rel=1e-9)


def test_law_and_bent_robot_combine_alike_with_a_gap() -> None:
    def waving(time: float) -> FloatArray:
        return np.array([150.0 * np.sin(30 * time)])

    as_laws = place_effects(TWO_MASS, [parse_effect(text, "test") for text in (PLAY, BENT)], as_laws=True)
    inside = place_effects(TWO_MASS, [parse_effect(text, "test") for text in (PLAY, BENT)])
    ours, theirs = (run(placed.robot, placed.laws, 300, waving) for placed in (as_laws, inside))
    np.testing.assert_allclose(ours, theirs, atol=1e-9)
    assert np.max(np.abs(ours - run(TWO_MASS, laws_of(TWO_MASS, PLAY), 300, waving))) > 1e-4


def test_hysteresis_turns_with_the_shaft_and_not_with_the_gap() -> None:
    def turning(robot: Robot, *texts: str) -> FloatArray:
        return run(robot, laws_of(robot, *texts), 40, lambda time: np.array([20.0]))

    in_the_gap, plain = turning(TWO_MASS, PLAY, LOSS), turning(TWO_MASS, PLAY)
    np.testing.assert_allclose(in_the_gap, plain, atol=1e-12)
    assert np.max(plain[:, 1]) > 3e-3  # three transition angles


def test_two_harmonics_add_up_and_conserve_power() -> None:
    other = "transmission_error@motor_1:amplitude=1e-3,order=9"
    motor, speed = 0.3, 2.0
    shift = wave(motor) + 1e-3 * np.sin(9 * motor)
    slope = 3e-3 * 5 * np.cos(5 * motor + 1) + 1e-3 * 9 * np.cos(9 * motor)
    torque = 6e4 * (motor + shift) + 30.0 * speed * (1 + slope)
    assert motor_torque(WAVE, other, motor=motor, speed=speed) == pytest.approx(torque, rel=1e-9)
    model = PlantModel(TWO_MASS, laws_of(TWO_MASS, WAVE, other))
    rate = model.derivative(np.array([0.0, motor, 0.0, speed]), np.zeros(1), np.zeros(6), ca.DM(0, 1))
    assert 4.0 * float(rate[3]) == pytest.approx(-torque * (1 + slope), rel=1e-9)
