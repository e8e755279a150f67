"""The diagnosis experiment: parts, limits of the nominal robot, seeds, standstill."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.design.default_controller import default_controller
from flexros.identify.diagnosis_experiment.course import Course, diagnosis_course
from flexros.identify.diagnosis_experiment.specification import WEIGHTS, DiagnosisSpecification
from flexros.robot import load_robot
from flexros.robot.robot import robot_from_data
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


def course(name: str, run_seed: int = 1, **settings: object) -> Course:
    robot = load_robot(name)
    law = default_controller(robot, robot.sample_time)
    specification = DiagnosisSpecification.model_validate(settings)
    return diagnosis_course(specification, robot, law, robot.sample_time, run_seed, robot.home)


@pytest.mark.slow
@pytest.mark.parametrize("length", [20.0, 40.0])
def test_lasts_about_as_long_as_asked_for(length: float) -> None:
    for name in ("four_mass", "e12"):
        assert 0.95 * length < course(name, length=length).trajectory.duration < 1.1 * length + 2.0


def test_holds_every_part_once_between_rests() -> None:
    names = [part.name for part in course("elbow").parts]
    assert names[0] == names[-1] == "standstill"
    assert sorted(names[1:-1]) == sorted(WEIGHTS)


def test_holds_the_parts_that_were_asked_for() -> None:
    parts = course("four_mass", parts=["creep", "creep", "moves"]).parts
    assert sorted(part.name for part in parts[1:-1]) == ["creep", "creep", "moves"]


@pytest.mark.slow
def test_is_the_same_for_the_same_seed_and_another_one_for_another() -> None:
    t = np.linspace(0.0, 40.0, 500)
    one, same, other = (course("e12", seed).trajectory.evaluate(t, 0) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.max(np.abs(one - other)) > 0.05


def test_its_own_seed_goes_before_that_of_the_run() -> None:
    t = np.linspace(0.0, 40.0, 500)
    one, other = (course("e12", run, seed=5).trajectory.evaluate(t, 0) for run in (1, 2))
    np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_stays_within_its_reach_and_speed() -> None:
    for name in ("four_mass_linear", "elbow", "six_axis"):
        made = course(name)
        motion = made.trajectory.evaluate(np.arange(0.0, made.trajectory.duration, 2e-3), 1)
        assert np.all(np.abs(motion[0] - motion[0][0]).max(axis=0) <= 1.3 * made.scales.reach)
        assert np.all(np.abs(motion[1]).max(axis=0) <= 1.3 * made.scales.speed)


def test_two_seconds_and_more_are_spent_at_rest() -> None:
    made = course("e12")
    motion = made.trajectory.evaluate(np.arange(0.0, made.trajectory.duration, 1e-3), 1)
    assert 1e-3 * np.sum(np.all(motion[1] == 0.0, axis=1)) > 2.0


def test_creep_turns_the_rotor_more_than_twice_both_ways() -> None:
    made = course("four_mass")
    begin, end = next((part.begin, part.end) for part in made.parts if part.name == "creep")
    motor_angle = made.trajectory.evaluate(np.arange(begin, end, 1e-3), 0)[0, :, 0]
    assert np.ptp(motor_angle) > 4 * np.pi


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed", "length"),
    [
        ("four_mass_linear", 2, 20.0),
        ("four_mass_linear", 3, 40.0),
        ("four_mass", 4, 40.0),
        ("elbow", 2, 20.0),
        ("emps", 3, 40.0),
    ],
)
def test_nominal_robot_keeps_its_torque_limits(name: str, seed: int, length: float) -> None:
    scenario = load_scenario("diagnosis").with_values({"robot": name, "seed": seed, "diagnosis.length": length})
    experiment = Experiment.prepare(scenario)
    torque = closed_loop(experiment).joint_commands.effort  # type: ignore[union-attr]
    assert np.all(np.abs(torque) < experiment.nominal.torque_limits)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "effects"),
    [
        ("four_mass_linear", ["delay@all:time=0.001", "stiffness_error@body_1.rz:relative=-0.2"]),
        ("four_mass", ["payload_error@tool:relative=0.3", "delay@all:time=0.001"]),
        ("e12", ["payload_error@tool:relative=0.3", "stiffness_error@body_2.ry:relative=-0.2"]),
        ("elbow", ["payload_error@tool:relative=0.3", "coulomb_friction@motor_1:level=60"]),
    ],
)
def test_robots_with_effects_are_held(name: str, effects: list[str]) -> None:
    scenario = load_scenario("diagnosis").with_values({"robot": name, "plant.effects": effects, "diagnosis.length": 20})
    log = closed_loop(Experiment.prepare(scenario))
    assert log.joint_reference is not None
    error = log.joint_states.position - log.joint_reference.position  # type: ignore[operator]
    last = round(0.3 / 5e-4)
    assert np.all(np.abs(error[-last:]) < 0.3 * np.abs(error).max(axis=0))  # what the moves left dies out


def test_excitation_is_far_above_the_noise_for_a_robot_without_torque_limits() -> None:
    made = course("e12")
    noise = load_robot("e12").encoder_noise
    for part in made.parts:
        if part.name != "standstill":
            motion = made.trajectory.evaluate(np.arange(part.begin, part.end, 1e-3), 0)[0]
            assert np.all(np.ptp(motion, axis=0) > 500 * noise)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("levels", [0.1, -1.0], r"levels is \[0\.1, -1\.0\], allowed are numbers above 0"),
        ("parts", ["creep", "hop"], r"key 'diagnosis\.parts\[1\]' is 'hop'.*'creep', 'presliding'"),
        ("length", 1.0, r"key 'diagnosis\.length' is 1\.0, but .* greater than or equal to 10"),
        ("creep_speeds", [0.0], r"creep_speeds is \[0\.0\], allowed are numbers above 0"),
    ],
)
def test_wrong_settings_are_refused(key: str, value: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario("diagnosis").with_values({f"diagnosis.{key}": value})


def test_band_without_width_is_refused() -> None:
    with pytest.raises(InputError, match=r"highest is 20 Hz, allowed is above lowest = 30 Hz; raise it"):
        load_scenario("diagnosis").with_values({"diagnosis.lowest": 30.0, "diagnosis.highest": 20.0})


def test_diagnosis_with_a_duration_is_refused() -> None:
    with pytest.raises(InputError, match="has diagnosis and duration, allowed is one of them"):
        load_scenario("diagnosis").with_values({"duration": 3.0})


def test_reach_for_another_number_of_motors_is_refused() -> None:
    with pytest.raises(InputError, match=r"diagnosis\.reach has 3 values, allowed is one, or one for each of the 2"):
        course("e12", reach=[0.1, 0.2, 0.3])


def test_robot_that_cannot_hold_itself_is_refused() -> None:
    weak = load_robot("elbow").with_values({}).spec.model_dump(exclude_unset=True)
    weak["bodies"][0]["directions"]["ry"]["motor"]["torque_limit"] = {"value": 100.0, "unit": "Nm"}
    robot = robot_from_data(weak, "weak.yaml")
    law = default_controller(robot, robot.sample_time)
    with pytest.raises(InputError, match=r"motor_1 needs .* to hold .*, allowed are 0\.75 times its torque limit"):
        diagnosis_course(DiagnosisSpecification(), robot, law, robot.sample_time, 1, robot.home)
