"""Friction that a robot file has no place for."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.rigid.fit import fit_rigid
from flexros.identify.rigid.friction_effects import friction_outside_file
from flexros.identify.rigid.settings import RigidSettings
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario


def friction(v: np.ndarray) -> np.ndarray:
    return 10 * np.sign(v) + 3


def test_coulomb_friction_and_offset_become_an_effect(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(8000, 1e-3, 1), noise=1e-6, friction=friction)
    outside = friction_outside_file(fit_rigid(log, emps, RigidSettings(cutoff=25.0)))
    assert outside.values["motor_1.coulomb_friction"] == pytest.approx(10, rel=0.02)
    assert outside.values["motor_1.torque_offset"] == pytest.approx(3, rel=0.02)
    assert outside.means == ()
    (effect,) = outside.effects
    name, _, numbers = effect.partition(":")
    assert name == "coulomb_friction@motor_1"
    read = dict(entry.split("=") for entry in numbers.split(","))
    assert float(read["level"]) == pytest.approx(10, rel=0.02)
    assert float(read["asymmetry"]) == pytest.approx(0.6, rel=0.03)


def test_friction_by_direction_is_the_same_effect(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(8000, 1e-3, 1), noise=1e-6, friction=friction)
    outside = friction_outside_file(fit_rigid(log, emps, RigidSettings(cutoff=25.0, asymmetric=True)))
    (effect,) = outside.effects
    read = dict(entry.split("=") for entry in effect.partition(":")[2].split(","))
    assert float(read["level"]) == pytest.approx(10, rel=0.03)
    assert float(read["asymmetry"]) == pytest.approx(0.6, rel=0.05)
    assert outside.means[0].startswith("motor_1.viscous_friction in the robot file is the mean of 20")


def test_no_effect_without_friction(elbow, fourier_motion, rigid_log) -> None:
    log = rigid_log(elbow, fourier_motion(8000, 1e-3, 2), noise=1e-6, friction=lambda v: -5 * np.sign(v))
    assert friction_outside_file(fit_rigid(log, elbow, RigidSettings(cutoff=25.0))).effects == ()


def test_an_offset_beyond_the_friction_is_a_constant_torque(emps, fourier_motion, rigid_log) -> None:
    """It acts against what the motor has to hold."""
    log = rigid_log(emps, fourier_motion(8000, 1e-3, 1), noise=1e-6, friction=lambda v: 2 * np.sign(v) + 9)
    friction, bias = friction_outside_file(fit_rigid(log, emps, RigidSettings(cutoff=25.0))).effects
    assert friction.startswith("coulomb_friction@motor_1:level=")
    assert float(friction.partition("=")[2]) == pytest.approx(2, rel=0.05)
    assert bias.startswith("torque_bias@motor_1:level=")
    assert float(bias.partition("=")[2]) == pytest.approx(-9, rel=0.02)


def test_effect_is_understood_by_a_scenario(emps, fourier_motion, rigid_log) -> None:
    log = rigid_log(emps, fourier_motion(8000, 1e-3, 1), noise=1e-6, friction=friction)
    (effect,) = friction_outside_file(fit_rigid(log, emps, RigidSettings(cutoff=25.0))).effects
    scenario = load_scenario("two_mass_step").with_values({"plant.effects": [effect]}, "--effect")
    (law,) = Experiment.prepare(scenario).laws
    assert law.name == "coulomb_friction@motor_1"
