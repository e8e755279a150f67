"""Difference of model and robot under the same control, in mm and mrad."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.effects import PlacedEffect, RobotWithEffects, place_effects
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.gap.held_out import closed_loop_gap as module
from flexros.gap.held_out.closed_loop_gap import closed_loop_gap, measured_alone, why_not_simulated
from flexros.logs.time_series import Log
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario

ROBOT = load_robot("four_mass_linear")
NOMINAL = RobotWithEffects(ROBOT, ())
REPAIRED = place_effects(ROBOT, [PlacedEffect(CoulombFriction(level=1.5), "motor_1")])


@pytest.fixture(scope="module")
def log() -> Log:
    """Moves of a robot with hidden friction."""
    scenario = Scenario.model_validate(
        {
            "name": "moves",
            "robot": "four_mass_linear",
            "plant": {"effects": ["coulomb_friction@motor_1:level=1.5"]},
            "trajectory": {
                "path": {"type": "joint_moves", "points_from_start": [[10.0]]},
                "time_law": {"type": "ninth_degree", "duration": 0.8},
            },
            "feedforward": {"method": "rigid"},
            "controller": {"kind": "pid", "kp": 22, "kd": 2.35, "derivative_filter": 2.6e-3},
        }
    )
    return closed_loop(Experiment.prepare(scenario))


def test_a_repaired_model_is_where_the_robot_is_but_for_noise(log: Log) -> None:
    tool, motor = closed_loop_gap(log, NOMINAL, REPAIRED)
    assert (tool.signal, tool.unit) == ("tool path in closed loop", "mm")
    assert tool.after is not None
    assert tool.before > 5 * tool.after
    assert tool.after == pytest.approx(tool.floor, rel=0.2)
    assert (motor.signal, motor.unit) == ("motor_1 position in closed loop", "mrad")
    assert motor.after == pytest.approx(motor.floor, rel=0.2)
    assert motor.before > 5 * motor.floor


def test_nothing_is_told_where_reference_and_controller_are_not_known(log: Log) -> None:
    assert closed_loop_gap(replace(log, provenance={}), NOMINAL) == ()
    other = {"scenario": {**log.provenance["scenario"], "robot": "no_such_robot"}}
    assert closed_loop_gap(replace(log, provenance=other), NOMINAL) == ()
    assert closed_loop_gap(log, NOMINAL, begin=1e6) == ()


def test_without_a_repair_only_the_gap_before_is_told(log: Log) -> None:
    tool, _ = closed_loop_gap(log, NOMINAL)
    assert tool.before > 0
    assert tool.after is None


def test_the_measurements_of_a_log_suffice(log: Log) -> None:
    assert closed_loop_gap(measured_alone(log), NOMINAL, REPAIRED) == closed_loop_gap(log, NOMINAL, REPAIRED)


def test_a_log_that_is_too_long_is_not_simulated_and_says_so(log: Log, monkeypatch: pytest.MonkeyPatch) -> None:
    assert why_not_simulated(log) == ()
    monkeypatch.setattr(module, "MOST_SAMPLES", 100)
    (warning,) = why_not_simulated(log)
    kept = measured_alone(log)
    assert closed_loop_gap(kept, NOMINAL) == ()
    assert (kept.joint_states.position, kept.tool_pose) == (None, None)
    assert str(len(log.joint_states.stamp)) in warning
    assert closed_loop_gap(log, NOMINAL, REPAIRED) == ()
    assert why_not_simulated(replace(log, provenance={})) == ()
