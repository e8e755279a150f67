"""Transmission error: the arm follows the harmonic at rest, power is conserved, resonances are excited."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects.gear.transmission_error import TransmissionError
from flexros.robot import load_robot
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import GearLaw, halving_errors, laws_of, run, still

TWO_MASS = load_robot("two_mass")


@pytest.mark.parametrize("position", [0.0, 0.3, 2.0])
def test_arm_at_rest_follows_the_harmonic(position: float) -> None:
    model = PlantModel(TWO_MASS, laws_of(TWO_MASS, "transmission_error@motor_1:amplitude=1e-3,order=2,phase=0.4"))
    rest = model.rest(np.array([position, position, 0.0, 0.0]))
    assert rest.state[0] == pytest.approx(position + 1e-3 * np.sin(2 * position + 0.4), abs=1e-12)
    assert rest.torque == pytest.approx(0.0, abs=1e-7)


def test_order_counts_turns_of_the_rotor() -> None:
    six_axis = load_robot("six_axis")
    model = PlantModel(six_axis, laws_of(six_axis, "transmission_error@motor_1:amplitude=1e-4,order=2"))
    state = six_axis.equilibrium(six_axis.home)
    ratio = six_axis.motors[0].gear_ratio
    place = six_axis.motor_rows[0]
    moved = []
    for turn in (0.0, 0.125, 1.0):
        start = state.copy()
        start[place] = turn * 2 * np.pi / ratio
        start[six_axis.gear_rows[0]] = start[place]
        moved.append(model.rest(start).state[six_axis.gear_rows[0]] - start[place])
    assert moved[1] - moved[0] == pytest.approx(1e-4, rel=1e-3)
    assert moved[2] - moved[0] == pytest.approx(0.0, abs=1e-8)


def test_power_is_kept() -> None:
    amplitude, order, turns = 2e-3, 3.0, 50.0
    law = GearLaw(TransmissionError(amplitude=amplitude, order=order, phase=0.3), 1e4, 20.0, 1e7, turns)
    motor_speed, arm_speed, angle, deflection = 0.7, -0.2, 1.1, 3e-3
    arm, motor = law.torques(deflection, np.zeros(0), motor_speed - arm_speed, angle, motor_speed)
    wave = order * angle + 0.3
    twist = deflection + amplitude * np.sin(wave)
    rate = motor_speed - arm_speed + amplitude * order * turns * motor_speed * np.cos(wave)
    assert arm == pytest.approx(1e4 * twist + 1e7 * twist**3 + 20.0 * rate)
    assert arm * arm_speed + motor * motor_speed == pytest.approx(-arm * rate)


def test_energy_of_an_undamped_robot_is_conserved() -> None:
    robot = TWO_MASS.with_values({"body_1.rz.damping": 0.0})
    law = laws_of(robot, "transmission_error@motor_1:amplitude=2e-3,order=9")
    path = run(robot, law, 1000, still(robot), np.array([0.0, 0.0, 10.0, 10.0]), substeps=8)
    twist = path[:, 1] - path[:, 0] + 2e-3 * np.sin(9 * path[:, 1])
    potential = 3e4 * twist**2
    energy = 5.0 * 10.0**2
    np.testing.assert_allclose(potential + 3.0 * path[:, 2] ** 2 + 2.0 * path[:, 3] ** 2, energy, rtol=1e-5)
    assert np.max(potential) > 0.1


def test_arm_shakes_most_where_order_times_speed_meets_the_antiresonance() -> None:
    antiresonance = np.sqrt(6e4 / 6.0)
    law = laws_of(TWO_MASS, "transmission_error@motor_1:amplitude=1e-5,order=20")

    def shaking(speed: float) -> float:
        heavy = TWO_MASS.with_values({"motor_1.inertia": 4e6})  # its speed is held
        path = run(heavy, law, 3000, still(heavy), np.array([0.0, 0.0, speed, speed]))
        return float(np.std(path[2000:, 0] - path[2000:, 1]))

    slow, resonant, fast = (shaking(ratio * antiresonance / 20) for ratio in (0.3, 1.0, 2.0))
    assert resonant > 5 * max(slow, fast)


def test_halving_the_step_converges() -> None:
    def waving(time: float) -> FloatArray:
        return np.array([100.0 * np.sin(6 * time)])

    errors = halving_errors(
        TWO_MASS, laws_of(TWO_MASS, "transmission_error@motor_1:amplitude=1e-3,order=6"), 300, waving
    )
    assert errors[1] < errors[0] / 10
    assert errors[0] < 1e-5


def test_amplitude_of_zero_switches_it_off() -> None:
    assert PlantModel(TWO_MASS, laws_of(TWO_MASS, "transmission_error@motor_1:amplitude=0")).laws == ()
