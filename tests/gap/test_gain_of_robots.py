"""The gain of the predictor is computed without trouble for every robot of the library."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from flexros.prediction.observer import observer_gain
from flexros.robot import load_robot

ROBOTS = ("e12", "elbow", "emps", "four_mass", "four_mass_linear", "six_axis", "two_mass")


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_no_step_of_it_is_ill_conditioned(name: str) -> None:
    robot = load_robot(name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for sample_time in (2.5e-4, 5e-4, 1e-3):
            for level in (1e-3, 0.3):
                found = observer_gain(robot, sample_time, level, robot.encoder_noise)
                assert np.all(found.spread >= robot.encoder_noise)
                assert np.all(found.ahead(50) >= robot.encoder_noise)


def test_the_covariance_is_the_stationary_one() -> None:
    robot = load_robot("six_axis")
    tolerated = np.full(robot.n_motors, 1e-2)
    found = observer_gain(robot, 5e-4, 1e-3, robot.encoder_noise, tolerated=tolerated)
    added = found.motion @ found.gain @ np.diag(found.noise**2) @ found.gain.T @ found.motion.T + found.taken
    predicted = solve_discrete_lyapunov(found.transition, added)
    expected = np.sqrt(np.diag(found.readout @ predicted @ found.readout.T) + found.noise**2)
    np.testing.assert_allclose(found.spread, expected, rtol=1e-8)
