from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.identify.graybox.fit import fit
from flexros.identify.graybox.problem import graybox_problem
from flexros.identify.graybox.residuals import residual_report

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot

    Responses = tuple[FrequencyResponse, ...]


def test_shares_add_up_and_noise_alone_gives_one(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "NLS", "optimal")
    report = residual_report(problem, fit(problem))
    assert len(report.cells) == 3 * 4 * 4
    assert sum(cell.share for cell in report.cells) == pytest.approx(1.0)
    assert {cell.position for cell in report.cells} == {0, 1, 2}
    assert report.chi_square == pytest.approx(1.0, abs=0.12)
    assert max(cell.largest for cell in report.cells) < 4.0


def test_what_the_model_misses_is_found(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "NLS", "optimal")
    result = fit(problem)
    spoilt = noisy_e12[1].response.copy()
    spoilt[30, 1, 0] += 20.0 * noisy_e12[1].standard_deviation("total")[30, 1, 0]
    responses = (noisy_e12[0], replace(noisy_e12[1], response=spoilt), noisy_e12[2])
    report = residual_report(replace(problem, responses=responses), result, bands=[10.0, 20.0, 30.0])
    worst = report.worst(1)[0]
    assert (worst.position, worst.output, worst.input) == (1, "motor_2", "motor_1")
    assert worst.lowest <= noisy_e12[0].frequency[30] <= worst.highest
    assert worst.at == noisy_e12[0].frequency[30]
    assert worst.largest > 10.0
    assert worst.chi_square > 5.0
    assert sum(cell.share for cell in report.cells if (cell.output, cell.input) == ("motor_2", "motor_1")) > 0.3


def test_without_covariance_shares_are_left(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    bare = tuple(replace(response, total_error=None) for response in noisy_e12)
    problem = graybox_problem(e12, bare, e12_names)
    report = residual_report(problem, fit(problem))
    assert np.isnan(report.chi_square)
    assert np.isnan(report.cells[0].largest)
    assert sum(cell.share for cell in report.cells) == pytest.approx(1.0)


def test_elements_without_weight_are_left_out(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "NLS", "optimal")
    weights = problem.weights.copy()
    weights[:, :, 0, 1] = 0.0
    report = residual_report(replace(problem, weights=weights), fit(problem), bands=2)
    assert len(report.cells) == 3 * 3 * 2
