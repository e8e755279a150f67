"""Hold, delay and aliases compared with the exact discretisation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import cont2discrete

from flexros.errors import InputError
from flexros.identify.frf.sampled import sampled_hold
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.robot import load_robot
from flexros.robot.linear.positions import LinearisedPositions, linearise_positions

FREQUENCY = np.geomspace(0.5, 100.0, 40)


def first_order(positions: LinearisedPositions) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """State space form of the first position, from torques to motor positions."""
    M, D, K = (matrix[0] for matrix in (positions.mass, positions.damping, positions.stiffness))
    n = len(M)
    E = np.eye(n)[positions.motor_rows]
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    return A, np.vstack([np.zeros((n, len(E))), np.linalg.solve(M, E.T)]), np.hstack([E, np.zeros_like(E)])


def discrete_response(positions: LinearisedPositions, T: float, delay: float) -> np.ndarray:
    """Exact response of sampled acceleration when a command acts from t_k + delay to t_{k+1} + delay."""
    A, B, C = first_order(positions)
    n, m = B.shape
    whole = int(delay / T + 1e-9)
    late = delay - whole * T

    def step(time: float) -> tuple[np.ndarray, np.ndarray]:
        both = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * time)
        return both[:n, :n], both[:n, n:]

    F = step(T)[0]
    after, now = step(T - late)
    before = after @ step(late)[1]
    z = np.exp(2j * np.pi * FREQUENCY * T)[:, None, None]
    x = np.linalg.solve(z * np.eye(n) - F, (now + before / z) * z ** -float(whole))
    response: np.ndarray = (2j * np.pi * FREQUENCY[:, None, None]) ** 2 * (C @ x)
    return response


def test_oracle_is_the_zero_order_hold_of_scipy() -> None:
    positions = linearise_positions(load_robot("e12"), ["body_1.ry.stiffness"], [[0.1, 0.2]])
    A, B, C = first_order(positions)
    F, G, *_ = cont2discrete((A, B, C, np.zeros((2, 2))), 5e-4)
    z = np.exp(2j * np.pi * FREQUENCY * 5e-4)[:, None, None]
    expected = (2j * np.pi * FREQUENCY[:, None, None]) ** 2 * (C @ np.linalg.solve(z * np.eye(len(A)) - F, G))
    np.testing.assert_allclose(discrete_response(positions, 5e-4, 0.0), expected, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.0, 3e-4, 5e-4, 1.2e-3])
@pytest.mark.parametrize("name", ["two_mass", "elbow", "e12", "four_mass_linear", "six_axis", "emps"])
def test_response_is_that_of_the_exact_discretisation(name: str, delay: float) -> None:
    robot = load_robot(name)
    motors = [robot.home[list(robot.gear_rows)]]
    positions = linearise_positions(robot, ["motor_1.inertia"], motors)
    model = FrequencyModel(positions, FREQUENCY, 5e-4, delay)
    expected = discrete_response(positions, 5e-4, delay)
    error = np.abs(model.response(positions.values)[0] - expected)
    assert np.max(error / np.abs(expected)) < 1e-7
    aliases = np.tensordot(model.hold.aliases[0], model.expansion[0], 1)
    assert np.max(np.abs(aliases) / np.abs(expected)) > 1e-5  # they are worth their while


def test_rows_of_frequencies_are_taken_as_they_are() -> None:
    frequency = np.array([[1.0, 2.0], [3.0, 4.0]])
    both = sampled_hold(frequency, 1e-3, 2e-4)
    single = sampled_hold(frequency[1], 1e-3, 2e-4)
    np.testing.assert_array_equal(both.gain[1], single.gain)
    np.testing.assert_array_equal(both.aliases[1], single.aliases)


@pytest.mark.parametrize("wrong", [0.0, 500.0, 700.0])
def test_frequency_beyond_sampling_is_reported(wrong: float) -> None:
    with pytest.raises(InputError, match=rf"a frequency of {wrong:g} Hz .* must lie between 0 and .* 500 Hz"):
        sampled_hold(np.array([1.0, wrong]), 1e-3)
