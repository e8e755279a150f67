"""From base parameters back to the robot file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from flexros.feedforward.rigid_arm import RigidArm
from flexros.identify.rigid.fit import fit_rigid
from flexros.identify.rigid.identified_robot import _base_values, _not_met, identified_values, identified_yaml
from flexros.identify.rigid.settings import RigidSettings
from flexros.robot import Robot, load_robot
from flexros.robot.robot import robot_from_data

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("unchecked")]

SLOW = RigidSettings(cutoff=25.0)
BODY = {
    1: {"mass": 5.0, "center_of_mass.z": 0.02, "inertia.zz": 0.03},
    2: {
        "mass": 2.0,
        "center_of_mass.z": 0.22,
        "center_of_mass.y": 0.03,
        "inertia.xx": 0.02,
        "inertia.yy": 0.02,
        "inertia.zz": 0.002,
    },
    3: {"mass": 0.5, "center_of_mass.z": 0.02, "inertia.xx": 0.0004, "inertia.yy": 0.0005, "inertia.zz": 0.0003},
}
THREE_AXES = """
name: three_axes
defaults: {source: a guess, tolerance: 0.03}
gravity: [0, 0, -9.81]
bodies:
  - {mass: 3, center_of_mass: [0, 0, 0.1], inertia: {xx: 0.02, yy: 0.02, zz: 0.02}, length: [0, 0, 0.2],
     directions: {rz: {spring: rigid, damper: 0, motor: {inertia: 0}}}}
  - {mass: 5, center_of_mass: [0, 0, 0.1], inertia: {xx: 0.05, yy: 0.05, zz: 0.02}, length: [0, 0, 0.4],
     directions: {ry: {spring: rigid, damper: 0, motor: {inertia: 0}}}}
  - {mass: 2, center_of_mass: [0, 0, 0.1], inertia: {xx: 0.02, yy: 0.02, zz: 0.005}, length: [0, 0, 0.3],
     directions: {rx: {spring: rigid, damper: 0, motor: {inertia: 0}}}}
outputs: {tool: {pose: [x, z]}, joints: {coordinates: [body_1.rz, body_2.ry, body_3.rx]}}
controlled: joints
"""


def _three_axes() -> Robot:
    """Return a robot with guessed masses."""
    return robot_from_data(yaml.safe_load(THREE_AXES), "three_axes.yaml")


def test_drive_gets_mass_and_viscous_friction(emps, fourier_motion, rigid_log) -> None:
    real = emps.with_values({"body_1.mass": 101.0, "motor_1.viscous_friction": 180.0})
    fit = fit_rigid(rigid_log(real, fourier_motion(8000, 1e-3, 1), noise=1e-6), emps, SLOW)
    identified = identified_values(fit)
    assert set(identified.values) == {"body_1.mass", "motor_1.viscous_friction"}
    assert identified.values["body_1.mass"].value == pytest.approx(101.0, rel=1e-3)
    assert identified.values["motor_1.viscous_friction"].value == pytest.approx(180.0, rel=1e-2)
    mass = fit.base.names.index("body_1.mass")
    assert identified.values["body_1.mass"].relative == pytest.approx(fit.deviation[mass] / fit.values[mass], rel=1e-3)


def test_both_directions_of_friction_give_their_mean(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(8000, 1e-3, 1), friction=lambda v: 40 * v * (v > 0))
    fit = fit_rigid(log, emps, RigidSettings(cutoff=25.0, asymmetric=True))
    assert identified_values(fit).values["motor_1.viscous_friction"].value == pytest.approx(223.5, rel=0.01)


def test_identified_file_of_the_elbow_gives_the_torques_of_the_real_one(
    elbow, fourier_motion, rigid_log, tmp_path: Path
) -> None:
    real = elbow.with_values({"body_2.mass": 52.0, "body_1.center_of_mass.z": 0.45, "motor_2.inertia": 28.0})
    fit = fit_rigid(rigid_log(real, fourier_motion(12_000, 1e-3, 2), noise=1e-6), elbow, SLOW, "moves")
    identified = identified_values(fit)
    assert identified.left_out == {}
    file = tmp_path / "identified.yaml"
    file.write_text(identified_yaml(fit, identified))
    new = load_robot(file)
    motion = fourier_motion(500, 1e-2, 2, seed=5)
    wanted, got, before = (RigidArm(robot).inverse_dynamics(motion).torque for robot in (real, new, elbow))
    assert np.linalg.norm(got - wanted) < 2e-3 * np.linalg.norm(wanted)
    assert np.linalg.norm(before - wanted) > 0.03 * np.linalg.norm(wanted)
    parameter = new.parameters["motor_2.inertia"]
    assert parameter.source == "identified by FlexROS, rigid regression of moves"
    assert 0 < parameter.tolerance < 0.05
    assert new.parameters["body_1.length.z"].source == elbow.parameters["body_1.length.z"].source


def test_what_cannot_be_is_left_out_and_said(elbow, fourier_motion, rigid_log) -> None:
    fit = fit_rigid(rigid_log(elbow, fourier_motion(8000, 1e-3, 2)), elbow, SLOW)
    values = fit.values.copy()
    values[fit.base.names.index("motor_2.inertia")] = -5.0
    identified = identified_values(replace(fit, values=values))
    assert "motor_2.inertia" not in identified.values
    assert "-5" in identified.left_out["motor_2.inertia"]
    assert identified.not_met == {"motor_2.inertia": pytest.approx(25.0)}
    assert {"body_2.inertia.yy", "motor_2.viscous_friction"} <= set(identified.values)


def test_friction_that_a_file_cannot_hold_is_never_missed(elbow, fourier_motion, rigid_log) -> None:
    real = elbow.with_values({"motor_2.inertia": 28.0})
    log = rigid_log(real, fourier_motion(8000, 1e-3, 2), noise=1e-6, friction=lambda v: 20 * np.sign(v))
    fit = fit_rigid(log, elbow, SLOW)
    values = _base_values(fit, np.zeros(len(fit.base.standard)))
    missed = _not_met(fit, values)
    assert "motor_2.inertia" in missed
    assert not any(name.endswith(("coulomb_friction", "torque_offset")) for name in missed)
    assert values[fit.base.names.index("motor_1.coulomb_friction")] == pytest.approx(20, rel=0.01)


def test_others_take_over_what_a_body_cannot_have(elbow, fourier_motion, rigid_log, tmp_path: Path) -> None:
    nominal = elbow.with_values({"body_1.inertia.yy": 0.5, "motor_1.inertia": 30.0})
    real = elbow.with_values({"body_1.inertia.yy": 0.5, "motor_1.inertia": 12.0})
    fit = fit_rigid(rigid_log(real, fourier_motion(12_000, 1e-3, 2), noise=1e-6), nominal, SLOW)
    identified = identified_values(fit)
    assert "body_1" in identified.left_out  # its share of the difference would make its inertia negative
    assert identified.not_met == {}
    file = tmp_path / "identified.yaml"
    file.write_text(identified_yaml(fit, identified))
    motion = fourier_motion(500, 1e-2, 2, seed=5)
    wanted, got = (RigidArm(robot).inverse_dynamics(motion).torque for robot in (real, load_robot(file)))
    assert np.linalg.norm(got - wanted) < 2e-3 * np.linalg.norm(wanted)


def test_rough_masses_lead_to_the_feasible_robot_that_explains_the_torque(fourier_motion, rigid_log) -> None:
    """Noise makes the most likely values infeasible at every body; their nominal ones leave half of the torque."""
    numbers = {f"body_{k}.{name}": value for k in (1, 2, 3) for name, value in BODY[k].items()}
    real = _three_axes().with_values(numbers)
    log = rigid_log(real, fourier_motion(12_000, 1e-3, 3), noise=2e-4)
    fit = fit_rigid(log, _three_axes(), RigidSettings(cutoff=10.0))
    identified = identified_values(fit)
    assert identified.left_out == {}
    assert fit.force_error(identified.base_values) < 1.2 * fit.error.total + 0.2
    _three_axes().with_values({name: entry.value for name, entry in identified.values.items()})


def test_first_moment_of_a_body_without_mass_is_undefined(fourier_motion, rigid_log) -> None:
    robot = load_robot("four_mass_linear")
    fit = fit_rigid(rigid_log(robot, fourier_motion(8000, 1e-3, 1)), robot, SLOW)
    identified = identified_values(fit)
    assert identified.left_out == {}  # neither mass nor moment: the centre stays where it is
    assert "body_1.inertia.zz" in identified.values


def test_identified_file_of_a_robot_in_space(fourier_motion, rigid_log, tmp_path: Path) -> None:
    robot = load_robot("six_axis")
    real = robot.with_values({"body_4.mass": 280.0, "body_7.center_of_mass.x": 0.25, "body_3.inertia.yy": 45.0})
    fit = fit_rigid(rigid_log(real, fourier_motion(5000, 1e-3, 6), noise=1e-6), robot, SLOW)
    identified = identified_values(fit)
    assert identified.left_out == {}
    file = tmp_path / "identified.yaml"
    file.write_text(identified_yaml(fit, identified))
    motion = fourier_motion(300, 1e-2, 6, seed=5)
    wanted, got, before = (RigidArm(r).inverse_dynamics(motion).torque for r in (real, load_robot(file), robot))
    assert np.linalg.norm(got - wanted) < 1e-3 * np.linalg.norm(wanted)
    assert np.linalg.norm(before - wanted) > 0.03 * np.linalg.norm(wanted)


@pytest.mark.parametrize(("name", "samples"), [("elbow", 8000), ("six_axis", 5000)])
def test_tolerances_allow_for_what_only_combinations_determine(
    name: str, samples: int, fourier_motion, rigid_log
) -> None:
    robot, rng = load_robot(name), np.random.default_rng(3)
    changed = {
        key: parameter.value * (1 + 0.12 * rng.normal())
        for key, parameter in robot.parameters.items()
        if key.endswith((".mass", ".inertia.yy", "motor_2.inertia")) or ".center_of_mass." in key
    }
    real = robot.with_values(changed)
    fit = fit_rigid(rigid_log(real, fourier_motion(samples, 1e-3, robot.n_motors), noise=1e-6), robot, SLOW)
    identified = identified_values(fit)
    assert identified.left_out == {}
    assert identified.not_met == {}
    errors = {
        key: (entry.value - real.parameters[key].value) / (entry.relative * abs(entry.value))
        for key, entry in identified.values.items()
    }
    assert max(abs(error) for error in errors.values()) < 4
    assert identified.values["body_2.mass" if name == "elbow" else "body_3.mass"].relative > 0.02


def test_tolerance_of_the_robot_file_is_the_prior(elbow, fourier_motion, rigid_log) -> None:
    known = elbow.spec.model_dump(mode="json")
    known["bodies"][1]["mass"]["tolerance"] = 1e-6
    known["bodies"][1]["center_of_mass"]["tolerance"] = 1e-6
    sure = robot_from_data(known, "test")
    fit = fit_rigid(rigid_log(elbow, fourier_motion(8000, 1e-3, 2), noise=1e-6), sure, SLOW)
    identified, unknown = identified_values(fit), identified_values(replace(fit, robot=elbow))
    assert identified.values["body_2.mass"].relative < 1e-4
    assert unknown.values["body_2.mass"].relative > 0.05


def test_parameters_that_act_like_hidden_ones_are_as_uncertain(fourier_motion, rigid_log) -> None:
    robot = load_robot("elbow")
    motion = fourier_motion(8000, 1e-3, 2)
    motion[:, :, 1] = 0.0
    real = robot.with_values({"body_2.mass": 60.0, "body_2.inertia.yy": 4.0})
    fit = fit_rigid(rigid_log(real, motion, noise=1e-6), robot, SLOW)
    assert fit.hidden
    identified = identified_values(fit)
    for key, entry in identified.values.items():
        assert abs(entry.value - real.parameters[key].value) < 4 * entry.relative * abs(entry.value), key
