"""Spring of unknown law: a curve over the deflection, in addition to the nominal spring."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.effects.gear.spring_curve import SpringCurve
from flexros.robot import load_robot
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import GearLaw, halving_errors, laws_of, run

SIZES = {
    "positive_25": 8.0,
    "positive_50": -5.0,
    "positive_75": 12.0,
    "positive_100": 50.0,
    "negative_25": -2.0,
    "negative_50": 15.0,
    "negative_75": -28.0,
    "negative_100": -30.0,
}
TEXT = "spring_curve@body_1.rz:" + ",".join(f"{name}={size}" for name, size in SIZES.items()) + ",low=-2e-3,high=2e-3"
TWO_MASS = load_robot("two_mass")


def more(deflection: float, **sizes: float) -> float:
    """Return the torque of a curve in addition to a spring of 6e4 Nm/rad, its last knots at 2 mrad [Nm]."""
    law = GearLaw(SpringCurve(low=-2e-3, high=2e-3, **sizes), 6e4)
    return law.torques(deflection, law.start(deflection))[0] - 6e4 * deflection


@pytest.mark.parametrize(
    ("deflection", "torque"),
    [(-5.0, -30), (-2.0, -30), (-1.5, -28), (-1.0, 15), (-0.5, -2), (0, 0), (0.25, 4), (1.25, 3.5), (2, 50), (9, 50)],
)
def test_torque_is_interpolated_between_knots_of_both_sides(deflection: float, torque: float) -> None:
    assert more(1e-3 * deflection, **SIZES) == pytest.approx(torque, abs=1e-9)


def test_torque_is_linear_in_its_sizes() -> None:
    for deflection in (-1.3e-3, 0.6e-3):
        parts = [more(deflection, **{name: size}) for name, size in SIZES.items()]
        assert sum(parts) == pytest.approx(more(deflection, **SIZES))


def test_motor_gets_the_opposite_torque() -> None:
    law = GearLaw(SpringCurve(low=-2e-3, high=2e-3, **SIZES), 6e4)
    arm, motor = law.torques(1.5e-3, law.start(1.5e-3))
    assert arm == pytest.approx(90.0 + 12.0)
    assert motor == pytest.approx(-arm)


def test_curve_through_a_straight_line_is_an_error_of_the_stiffness() -> None:
    def twisted(time: float) -> np.ndarray:
        return np.array([60.0 * np.sin(90 * time)])

    parts = (25, 50, 75, 100)  # of 2 mrad and 24 Nm: 12000 Nm/rad
    sizes = [f"positive_{part}={0.24 * part},negative_{part}={-0.24 * part}" for part in parts]
    line = f"spring_curve@body_1.rz:{','.join(sizes)},low=-2e-3,high=2e-3"
    with_curve = run(TWO_MASS, laws_of(TWO_MASS, line), 200, twisted)
    stiffer = run(TWO_MASS.with_values({"body_1.rz.stiffness": 7.2e4}), (), 200, twisted)
    assert np.max(np.abs(stiffer[:, 1] - stiffer[:, 0])) < 2e-3
    np.testing.assert_allclose(with_curve, stiffer, atol=1e-12)
    assert np.max(np.abs(with_curve - run(TWO_MASS, (), 200, twisted))) > 1e-5


def test_curve_of_a_passive_spring_acts_on_the_arm() -> None:
    robot = load_robot("four_mass_linear")
    sizes = ",".join(f"positive_{part}={0.04 * part},negative_{part}={-0.04 * part}" for part in (25, 50, 75, 100))
    laws = laws_of(robot, f"spring_curve@body_2.rz:{sizes},low=-0.2,high=0.2")  # 20 Nm/rad

    def twisted(time: float) -> np.ndarray:
        return np.array([5.0 * np.sin(60 * time)])

    softer = run(robot, (), 200, twisted)
    stiffer = run(robot.with_values({"body_2.rz.stiffness": 130.0}), (), 200, twisted)
    assert 1e-3 < np.max(np.abs(stiffer[:, 1])) < 0.2
    np.testing.assert_allclose(run(robot, laws, 200, twisted), stiffer, atol=1e-10)
    assert np.max(np.abs(stiffer - softer)) > 1e-4


def test_gap_of_a_backlash_counts_before_the_curve() -> None:
    def arm_torque(*texts: str, motor: float) -> float:
        model = PlantModel(TWO_MASS, laws_of(TWO_MASS, *texts))
        state = model.start(np.array([0.0, motor, 0.0, 0.0]))
        return 6.0 * float(model.derivative(state, np.zeros(1), np.zeros(6), ca.DM(0, 1))[2])

    gap = "backlash@motor_1:gap=0.02"
    for order in ((gap, TEXT), (TEXT, gap)):
        assert arm_torque(*order, motor=0.0115) == pytest.approx(90.0 + 12.0)
        assert arm_torque(*order, motor=-0.011) == pytest.approx(-60.0 + 15.0)


def test_rest_under_gravity_includes_the_curve() -> None:
    robot = load_robot("elbow")
    name = next(name for name in robot.arm_names if f"{name}.stiffness" in robot.parameters)
    laws = laws_of(robot, f"spring_curve@{name}:positive_50=40,positive_100=50,negative_50=-20,low=-1e-3,high=1e-3")
    rest = PlantModel(robot, laws).rest(robot.equilibrium())
    plant = Plant(robot, robot.sample_time, rest.state, torque=rest.torque, laws=laws)
    for _ in range(200):
        plant.advance(rest.torque)
    np.testing.assert_allclose(plant.state, rest.state, atol=1e-9)


def test_energy_of_an_undamped_robot_is_conserved() -> None:
    robot = TWO_MASS.with_values({"body_1.rz.damping": 0.0})
    start = np.array([1.8e-3, 0.0, 0.0, 0.0])
    path = run(robot, laws_of(robot, TEXT), 500, lambda time: np.zeros(1), start, 32)
    knots = np.linspace(-2e-3, 2e-3, 9)
    torque = [more(knot, **SIZES) for knot in knots]
    fine = np.linspace(-2e-3, 2e-3, 40001)
    stored = np.concatenate(
        [[0.0], np.cumsum(np.diff(fine) * np.convolve(np.interp(fine, knots, torque), [0.5, 0.5], "valid"))]
    )
    deflection = path[:, 1] - path[:, 0]
    energy = 3.0 * path[:, 2] ** 2 + 2.0 * path[:, 3] ** 2 + 3e4 * deflection**2 + np.interp(deflection, fine, stored)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-4)


def test_halving_the_step_converges() -> None:
    errors = halving_errors(TWO_MASS, laws_of(TWO_MASS, TEXT), 200, lambda time: np.array([90.0 * np.sin(80 * time)]))
    assert errors[0] < 1e-6
    assert errors[3] < errors[0] / 20


def test_curve_without_sizes_is_switched_off() -> None:
    assert SpringCurve(high=3.0).neutral
    assert not SpringCurve(negative_25=0.1).neutral


def test_sides_may_reach_differently_far() -> None:
    law = GearLaw(SpringCurve(low=-1e-3, high=4e-3, positive_50=10.0, negative_50=20.0), 6e4)
    added = [law.torques(1e-3 * d, law.start(1e-3 * d))[0] - 60 * d for d in (2.0, 1.0, -0.5, -0.25)]
    assert added == pytest.approx([10.0, 0.0, 20.0, 0.0])


@pytest.mark.parametrize(
    ("low", "sides"), [(0.0, {"positive"}), (-1e-4, {"positive"}), (-1e-3, {"positive", "negative"})]
)
def test_log_shows_the_sides_to_which_the_spring_is_turned(low: float, sides: set[str]) -> None:
    assert {name.partition("_")[0] for name in SpringCurve(low=low, high=3e-3).shown} == sides
