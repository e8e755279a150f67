"""Repairs by a far too large inertia, which predict hardly better than that motors move on at constant speed."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import yaml

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.fit.torques.unknown_numbers import inertias_of_bodies
from flexros.gap.held_out.constant_speed import moving_on, moving_on_words
from flexros.gap.measure_gap import MeasuredGap, measure_gap
from flexros.gap.report.terminal import gap_verdict
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data
from tests.gap.rigid_arm import arm, record_of_arm

T, INERTIA, FRICTION, NOISE = 0.004, 0.004, 0.002, 2e-4
MOTOR = """
name: motor
defaults: {source: chosen, tolerance: 0.1}
gravity: [0, 0, 0]
sample_time: 0.004
sensors: {encoder_noise: 2.0e-4}
bodies:
  - {mass: 0.1, inertia: {zz: 1.0e-6}, directions: {rz: {spring: rigid, motor: {inertia: 0.004}}}}
outputs: {joints: {coordinates: [body_1.rz]}}
controlled: joints
"""


@cache
def motor() -> Robot:
    return robot_from_data(yaml.safe_load(MOTOR), "motor.yaml")


def log_of(frequency: float, friction: float = FRICTION, inertia: float = INERTIA) -> Record:
    """Return a log of a motor whose speed swings between 0.7 and 1.3 rad/s at a frequency [Hz]."""
    time, w = T * np.arange(2500), 2 * np.pi * frequency
    position, acceleration = time - 0.3 / w * np.cos(w * time), 0.3 * w * np.cos(w * time)
    torque = inertia * acceleration + friction
    held = 0.5 * (torque + np.append(torque[1:], torque[-1]))
    measured = position + NOISE * np.random.default_rng(1).standard_normal(len(time))
    valid = np.ones(len(time), dtype=bool)
    return Record("log", T, measured[:, None], held[:, None], valid, measured_torque=True, imported=True)


def gap_with(effect: str, record: Record) -> MeasuredGap:
    """Measure the gap of a log before and after a repair."""
    repaired = place_effects(motor(), [parse_effect(effect, "test")])
    return measure_gap(record, RobotWithEffects(motor(), ()), repaired=repaired)


def test_an_inertia_that_holds_the_speed_closes_no_gap() -> None:
    """With 900 times the inertia of an ankle a slow log was within noise, and its export was proposed."""
    measured = gap_with("motor_inertia_error@motor_1:relative=900", log_of(1e-4))
    assert measured.numbers.closed_fraction == pytest.approx(1.0, abs=0.01)
    assert not measured.left.beyond
    assert measured.significant
    assert measured.left.moving_on == ("motor_1",)
    assert measured.warnings[0].startswith("motor_1 is predicted 0.1 s ahead hardly better than")
    assert gap_verdict(measured.left, "the repaired model").startswith("a gap: the repaired model predicts motor_1")


def test_the_friction_that_was_missing_closes_it() -> None:
    """Constant speed predicts a slow log as well as any model, but this one moves no inertia."""
    measured = gap_with(f"coulomb_friction@motor_1:level={FRICTION}", log_of(1e-4))
    assert not measured.significant
    assert not measured.left.moving_on


def test_an_inertia_that_was_missing_closes_it() -> None:
    """Such torques show it: constant speed leaves far more."""
    measured = gap_with("motor_inertia_error@motor_1:relative=4", log_of(2.0, friction=0.0, inertia=5 * INERTIA))
    assert measured.numbers.closed_fraction == pytest.approx(1.0, abs=0.02)
    assert not measured.significant


def test_a_rotor_that_the_file_leaves_out_has_no_nominal_size() -> None:
    """Rotors are far larger than the bodies of a wrist, and slow motion shows little of them."""
    nothing: Any = None
    assert moving_on(nothing, arm(), nothing, nothing, nothing) == []


def test_nothing_is_said_where_motors_are_predicted() -> None:
    assert moving_on_words(()) == []
    (text,) = moving_on_words(("motor_1", "motor_2"))
    assert "motor_1, motor_2 are predicted" in text
    assert "if they moved on" in text


def test_a_repair_may_have_numbers_of_no_possible_body() -> None:
    """Tolerated inertias of a thin body no longer summed up to the largest, and a diagnosis ended in an error."""
    robot, record, thin = arm(), record_of_arm(imported=True, seconds=4.0), {"body_2.inertia.yy": 1.04}
    nominal, heavier = (inertias_of_bodies(record, robot, numbers) for numbers in ({}, thin))
    assert heavier["motor_2"] == pytest.approx(nominal["motor_2"] + 1.0)
