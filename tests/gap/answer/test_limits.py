"""What a log cannot tell is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.answer.decision import Findings
from flexros.gap.answer.limits import cannot_tell
from flexros.gap.fit.least_squares import CandidateFit
from flexros.gap.search.forward_selection import Explanations
from flexros.gap.search.model_probability import ModelComparison
from tests.gap.diagnosis_logs import MODEL, data_of, predictor_of


@pytest.fixture(name="told")
def told_fixture():
    def told(tool: bool = False, **changes: object) -> str:
        """Say it of a log without effects, changed."""
        data = data_of(tool=tool)
        nothing = CandidateFit(predictor_of(), np.zeros(0), float(data.n_values))
        found = Explanations(
            ModelComparison(nothing, (), data.n_values), nothing, (nothing,), np.ones(1), detected=False
        )
        data = replace(data, record=replace(data.record, **changes))
        return " ".join(cannot_tell(Findings(MODEL, data, data, found)))

    return told


def test_an_unmeasured_tool_hides_errors_of_lengths(told) -> None:
    assert "kinematic_error" in told()
    assert "kinematic_error" not in told(tool=True)


def test_a_commanded_torque_hides_the_torque_constant(told) -> None:
    assert "torque constant" in told()
    assert "torque constant" not in told(measured_torque=True)


def test_torques_far_below_the_limit_test_no_saturation(told) -> None:
    limit = MODEL.robot.torque_limits[0]
    small = np.full((100, 1), 0.25 * limit)
    assert "motor_1 was given at most 25 % of its torque limit" in told(torque=small)
    assert "saturation" not in told(torque=4 * small)


def test_nothing_is_known_near_half_the_sampling_frequency(told) -> None:
    assert "above 800 Hz" in told()


def test_without_gravity_masses_and_inertias_are_one(told) -> None:
    assert "Without gravity" in told()
