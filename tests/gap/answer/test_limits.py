"""Limits of a log: what its signals cannot show is stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.gap.answer.limits import identifiability_limits
from flexros.record.quantization import Quantization
from tests.gap.diagnosis_logs import ROBOT, record_of


def limits(tool: bool = False, **changes: object) -> str:
    """State the limits of a log without effects, changed."""
    return " ".join(identifiability_limits(replace(record_of(tool=tool), **changes), ROBOT))  # type: ignore[arg-type]


def test_an_unmeasured_tool_hides_errors_of_lengths() -> None:
    assert "kinematic_error" in limits()
    assert "kinematic_error" not in limits(tool=True)


def test_a_commanded_torque_hides_the_torque_constant() -> None:
    assert "torque constant" in limits()
    assert "torque constant" not in limits(measured_torque=True)


def test_torques_far_below_the_limit_test_no_saturation() -> None:
    limit = ROBOT.torque_limits[0]
    small = np.full((100, 1), 0.25 * limit)
    assert "motor_1 reached at most 25 % of its torque limit" in limits(torque=small)
    assert "saturation" not in limits(torque=4 * small)


def test_nothing_is_known_near_half_the_sampling_frequency() -> None:
    assert "above 800 Hz" in limits()


def test_without_gravity_masses_and_inertias_are_one() -> None:
    assert "Without gravity" in limits()


def test_a_fine_encoder_step_is_stated_as_noise() -> None:
    fine, coarse = Quantization(0, 3e-5, coarse=False), Quantization(0, 1e-3)
    stated = " ".join(identifiability_limits(record_of(), ROBOT, (fine,)))
    assert "motor_1" in stated
    assert "3e-05 rad, 0.3 of its noise" in stated
    assert "rounds" not in " ".join(identifiability_limits(record_of(), ROBOT, (coarse,)))
