"""Laws of Coulomb friction: it brakes, it sticks, it converges."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects import parse_effect, place_effects
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.errors import InputError
from flexros.robot import Robot, load_robot, robot_from_data
from flexros.simulate.disturbance import AbstractDisturbance, Pulse, Step
from flexros.simulate.plant import Plant

T = 1e-3
TWO_MASS = load_robot("two_mass")


def plant(
    robot: Robot,
    effect: str,
    start: FloatArray,
    disturbances: tuple[AbstractDisturbance, ...] = (),
    substeps: int = 1,
) -> Plant:
    placed = place_effects(robot, [parse_effect(text, "test") for text in effect.split()])
    return Plant(placed.robot, T, start, disturbances=disturbances, substeps=substeps, laws=placed.laws)


def states(moving: Plant, samples: int) -> FloatArray:
    rows = [moving.state]
    for _ in range(samples):
        moving.advance(np.zeros(moving.robot.n_motors))
        rows.append(moving.state)
    return np.array(rows)


def slide() -> Robot:
    """Return a rigid slide without other friction."""
    return load_robot("emps").with_values({"motor_1.viscous_friction": 0.0})


@pytest.mark.parametrize(("speed", "level"), [(0.4, 12.0), (-0.4, 8.0)])
def test_sliding_mass_stops_after_the_distance_of_its_energy(speed: float, level: float) -> None:
    robot = slide()
    mass = robot.parameters["motor_1.inertia"].value + robot.parameters["body_1.mass"].value
    path = states(plant(robot, "coulomb_friction@motor_1:level=10,asymmetry=0.4", np.array([0.0, speed])), 6000)
    stop = mass * abs(speed) / level
    assert path[-1, 0] == pytest.approx(np.sign(speed) * mass * speed**2 / (2 * level), abs=level / mass * T**2)
    during = round(0.5 * stop / T)
    assert path[during, 1] == pytest.approx(speed - np.sign(speed) * level / mass * during * T, rel=1e-9)
    assert abs(path[-1, 1]) < 1e-18


def test_motor_sticks_under_less_torque_than_the_level_for_ever() -> None:
    pushed = plant(
        TWO_MASS, "coulomb_friction@motor_1:level=50", np.zeros(4), (Step(kind="step", at="motor_1", amplitude=-49.0),)
    )
    assert np.max(np.abs(states(pushed, 2000))) < 1e-20


def test_motor_slips_under_more_torque_than_the_level() -> None:
    pushed = plant(
        TWO_MASS, "coulomb_friction@motor_1:level=50", np.zeros(4), (Step(kind="step", at="motor_1", amplitude=-51.0),)
    )
    path = states(pushed, 2000)
    momentum = 6.0 * path[-1, 2] + 4.0 * path[-1, 3]  # the arm swings, the sum knows only torque minus level
    assert momentum == pytest.approx(-1.0 * 2.0, rel=1e-6)


def test_arm_swings_on_a_sticking_motor_that_stays_where_it_is() -> None:
    robot = TWO_MASS.with_values({"body_1.rz.damping": 0.0})
    path = states(plant(robot, "coulomb_friction@motor_1:level=50", np.array([8e-4, 0.0, 0.0, 0.0])), 4000)
    torque = 6e4 * (path[:, 0] - path[:, 1])
    assert np.max(torque) == pytest.approx(48.0, rel=1e-3)
    assert np.max(torque[-200:]) == pytest.approx(48.0, rel=2e-3)  # it still swings
    bound = 2 * 48.0 * T**2 / (12 * 4.0)
    assert np.max(np.abs(path[:, 1])) < 1.05 * bound
    assert np.max(path[-200:, 1]) - np.max(path[200:400, 1]) < 0.01 * bound  # no drift


def test_energy_only_falls() -> None:
    robot = TWO_MASS.with_values({"body_1.rz.damping": 0.0})
    path = states(plant(robot, "coulomb_friction@motor_1:level=20", np.array([0.0, 0.02, 1.0, 0.0])), 1500)
    energy = 3.0 * path[:, 2] ** 2 + 2.0 * path[:, 3] ** 2 + 3e4 * (path[:, 0] - path[:, 1]) ** 2
    assert np.max(np.diff(energy)) < 1e-6 * energy[0]
    assert energy[-1] < 0.2 * energy[0]


def test_substeps_converge_with_order_two_through_reversals_and_standstill() -> None:
    pulses = tuple(
        Pulse(kind="pulse", at="motor_1", amplitude=amplitude, start=start, width=0.2)
        for start, amplitude in ((0.05, 300.0), (0.3, -390.0), (0.6, 60.0))
    )
    effect = "coulomb_friction@motor_1:level=100,asymmetry=0.3"

    def path(substeps: int) -> FloatArray:
        return states(plant(TWO_MASS, effect, np.zeros(4), pulses, substeps), 1000)[:, 1]

    exact = path(512)
    errors = [float(np.max(np.abs(path(substeps) - exact))) for substeps in (1, 64)]
    assert errors[0] < 1e-4 * np.max(np.abs(exact))
    assert np.log2(errors[0] / errors[1]) / 6 > 1.8


def test_motors_that_act_on_each_other_stick_together() -> None:
    data = load_robot("elbow").spec.model_dump()
    for body in data["bodies"]:
        for direction in body["directions"].values():
            if direction["motor"]:
                direction["spring"] = "rigid"
    robot = robot_from_data(data, "elbow with rigid gears")
    start = np.concatenate([robot.home, np.zeros(robot.n_arm)])
    needed = np.abs(robot.holding_torque(start))
    assert np.all(needed > 10)
    levels = " ".join(f"coulomb_friction@motor_{k + 1}:level={1.05 * torque}" for k, torque in enumerate(needed))
    path = states(plant(robot, levels, start), 1000)
    assert np.max(np.abs(path[-1] - start)) < 1e-9


def test_levels_at_one_motor_add() -> None:
    twice, once = (
        states(plant(TWO_MASS, effect, np.array([0.0, 0.0, 0.5, 0.5])), 300)
        for effect in (
            "coulomb_friction@motor_1:level=8 coulomb_friction@motor_1:level=4",
            "coulomb_friction@motor_1:level=12",
        )
    )
    np.testing.assert_allclose(twice, once, atol=1e-15)


def test_contacts_with_a_stiffness_are_bristles() -> None:
    start, numbers = np.array([0.0, 0.0, 1.0, 1.0]), "level=20,stiffness=1e7,damping=2e3"
    path, bristles, rigid = (
        states(plant(TWO_MASS, f"{effect}_friction@motor_1:{values}", start), 400)
        for effect, values in (("coulomb", numbers), ("presliding", numbers), ("coulomb", "level=20"))
    )
    assert np.array_equal(path[:, :4], bristles[:, :4])
    assert 0 < np.max(np.abs(path[:, 1] - rigid[:, 1])) < 1e-3 * np.max(rigid[:, 1])


def test_bristles_keep_the_name_of_the_effect() -> None:
    placed = place_effects(TWO_MASS, [parse_effect("coulomb_friction@motor_1:level=20,stiffness=1e7", "test")])
    assert [law.name for law in placed.with_effects([]).laws] == ["coulomb_friction@motor_1"]


def test_uneven_bristles_are_refused() -> None:
    with pytest.raises(InputError, match="asymmetry 0.3"):
        parse_effect("coulomb_friction@motor_1:level=20,stiffness=1e7,asymmetry=0.3", "test")


def test_level_below_zero_reduces_another_one_at_most_to_zero() -> None:
    start = np.array([0.0, 0.0, 0.3, 0.3])
    both = plant(TWO_MASS, "coulomb_friction@motor_1:level=2 coulomb_friction@motor_1:level=-1.5", start)
    np.testing.assert_allclose(
        states(both, 200), states(plant(TWO_MASS, "coulomb_friction@motor_1:level=0.5", start), 200)
    )
    for wrong in ("level=-2.5", "level=-2.5,asymmetry=0.1"):
        with pytest.raises(InputError, match="at least -2"):
            plant(TWO_MASS, f"coulomb_friction@motor_1:level=2 coulomb_friction@motor_1:{wrong}", start)


def test_all_coulomb_friction_that_a_model_has_there_can_be_taken_away() -> None:
    robot = load_robot("two_mass")
    known = [CoulombFriction(level=0.3), ViscousFriction(coefficient=1.0), CoulombFriction(level=0.1)]
    assert CoulombFriction().reductions(robot, "motor_1", known)["level"] == pytest.approx(0.4)
    assert CoulombFriction().reductions(robot, "motor_1")["level"] == 0.0
