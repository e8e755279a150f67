"""Friction under load is found with its size, beside friction without load and not instead of it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from flexros.gap.diagnose import diagnose
from flexros.gap.schema import Cause
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.robot import Robot, load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.gap.rigid_arm import arm, record_of_arm

pytestmark = pytest.mark.slow

FRICTION = ("coulomb_friction", "viscous_friction", "load_dependent_friction", "presliding_friction", "friction_curve")
OTHERS = ("torque_gain_error", "torque_bias", "motor_inertia_error", "stiffness_error", "payload_error")
SETTINGS = DiagnosisSettings(
    where=None, next_experiment=None, sensitivity=None, search=SearchSettings(effects=(*FRICTION, *OTHERS))
)
ELBOW = load_robot("elbow")
LENGTH = 5.0
"""Of the logs of the elbow [s]."""
LEVEL = {"coulomb_friction@motor_1", "coulomb_friction@motor_2", "viscous_friction@motor_1", "viscous_friction@motor_2"}


@cache
def elbow_log(*effects: str, seed: int) -> Record:
    keys = {"robot": ELBOW.name, "diagnosis.length": 10.0, "seed": seed, "plant.effects": list(effects)}
    scenario = load_scenario("diagnosis").with_values(keys, "test")
    record = read_record(closed_loop(Experiment.prepare(scenario)), ELBOW, name="log")
    return replace(record, tool=None).part(0, round(LENGTH / record.sample_time))


def causes(robot: Robot, log: Record, held: Record) -> dict[str, Cause]:
    found = diagnose(log, robot, holdout=held, settings=SETTINGS).diagnosis
    assert found.verdict == "explained"
    return {f"{one.effect}@{one.location}": one for one in found.causes}


def of_elbow(*effects: str) -> dict[str, Cause]:
    return causes(ELBOW, elbow_log(*effects, seed=1), elbow_log(*effects, seed=2))


def of_arm(share: float) -> dict[str, Cause]:
    """Torques of a rigid arm by inverse dynamics, as of a real machine, with Coulomb and viscous friction."""
    log, held = (record_of_arm(imported=True, seed=seed, share=share, seconds=10.0) for seed in (5, 6))
    return causes(arm(), log, held)


def near(cause: Cause, name: str, size: float) -> None:
    value, std = cause.parameters[name].value, cause.parameters[name].std
    assert std is not None
    assert abs(value - size) < 4 * std < 0.5 * size


def test_share_of_the_load_is_found_beside_a_constant_level() -> None:
    found = of_elbow("coulomb_friction@motor_2:level=5", "load_dependent_friction@motor_2:share=0.05")
    assert set(found) == {"coulomb_friction@motor_2", "load_dependent_friction@motor_2"}
    near(found["load_dependent_friction@motor_2"], "share", 0.05)
    near(found["coulomb_friction@motor_2"], "level", 5.0)


def test_constant_level_is_not_called_load_dependent() -> None:
    found = of_elbow("coulomb_friction@motor_2:level=20")
    assert set(found) == {"coulomb_friction@motor_2"}
    near(found["coulomb_friction@motor_2"], "level", 20.0)


def test_share_is_found_beside_the_friction_of_a_measured_log() -> None:
    found = of_arm(0.2)
    assert set(found) == {*LEVEL, "load_dependent_friction@motor_1"}
    near(found["load_dependent_friction@motor_1"], "share", 0.2)


def test_friction_of_a_measured_log_without_it_is_not_called_load_dependent() -> None:
    assert set(of_arm(0.0)) == LEVEL
