"""Moves between positions: slow enough for the torque limits, against the check of the whole experiment."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.design.moves import FACTORS, move_factor
from flexros.identify.experiment.specification import MoveSettings
from flexros.robot import load_robot
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

SIX_AXIS, E12 = load_robot("six_axis"), load_robot("e12")
FAR = [[0.25, 1.05, -0.6, 0.1, 0.2, 0.4], [0.5183, -0.796, -0.8917, 0.1188, 1.0163, 0.9701]]


def test_torque_is_that_of_a_rotating_inertia() -> None:
    """E12 swings its first axis alone: inertia of the stretched arm and its motor times the acceleration."""
    positions, move = np.array([[1.0, 0.0]]), MoveSettings(speed=1e-3, acceleration=2.0)
    inertia = E12.model.arm_inertia([0, 0, 0], []).full()[0, 0] + 100.0
    torque = 2.0 * inertia
    enough = np.array([torque / 0.92, np.inf])
    assert move_factor(E12, np.zeros(2), positions, move, enough) == 1.0
    assert move_factor(E12, np.zeros(2), positions, move, 0.97 * enough) == FACTORS[1]
    assert move_factor(E12, np.zeros(2), positions, move, 0.3 * enough) == FACTORS[4]


def test_robot_that_stays_or_has_no_limits_moves_as_it_likes() -> None:
    assert move_factor(E12, np.zeros(2), np.zeros((2, 2)), MoveSettings(), np.full(2, 1e-6)) == 1.0
    assert move_factor(E12, np.zeros(2), np.ones((1, 2)), MoveSettings(), np.full(2, np.inf)) == 1.0


@pytest.mark.slow
def test_lowered_moves_pass_the_check_that_refuses_the_fast_ones() -> None:
    scenario = load_scenario("identify_six_axis").with_values(
        {"identification.positions": FAR, "identification.blocks": [1, 0], "identification.move.acceleration": 6.0,
         "identification.move.speed": 2.0, "identification.excitation.amplitude": 0.001}
    )  # fmt: skip
    specification = scenario.identification
    assert specification is not None
    start = SIX_AXIS.home[list(SIX_AXIS.gear_rows)]
    allowed = specification.limits.torque_share * scenario.controller.command_limits(SIX_AXIS)
    factor = move_factor(SIX_AXIS, start, np.array(FAR[:1]), specification.move, allowed)
    assert factor < 1
    with pytest.raises(InputError, match="motor_. needs .* Nm to move there"):
        _ = Experiment.prepare(scenario).reference
    lowered = {"acceleration": 6.0 * factor, "speed": 2.0 * float(np.sqrt(factor))}
    _ = Experiment.prepare(scenario.with_values({"identification.move": lowered})).reference
