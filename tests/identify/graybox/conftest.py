"""Synthetic frequency responses with known truth and known covariance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
import pytest

from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.robot.linear.positions import linearise_positions
from flexros.robot.robot import Robot, load_robot, robot_from_data

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

E12_POSES = np.array([[0.0, 0.3], [0.2, 1.2], [0.1, -0.9]])
E12_FREQUENCY = np.linspace(1.0, 40.0, 60)
SIX_AXIS_POSES = np.array([0.0, 0.2, 0.2, 0.2, 0.6, 0.3]) + np.random.default_rng(0).uniform(-0.8, 0.8, (4, 6))
SIX_AXIS_FREQUENCY = np.arange(3.0, 60.0, 1.5)


class Measure(Protocol):
    """Makes responses of a robot."""

    def __call__(
        self, robot: Robot, poses: FloatArray, frequency: FloatArray, noise: float = 0.0, seed: int = 0
    ) -> tuple[FrequencyResponse, ...]: ...


def measure(
    robot: Robot, poses: FloatArray, frequency: FloatArray, noise: float = 0.0, seed: int = 0
) -> tuple[FrequencyResponse, ...]:
    """Exact responses plus circular noise of `noise` times the rows' median magnitude; the covariance is stated."""
    names = [name for name in robot.parameters if name.endswith("stiffness")]
    positions = linearise_positions(robot, names, poses)
    exact = FrequencyModel(positions, frequency, robot.sample_time, robot.delay).response(positions.values)
    rng, n = np.random.default_rng(seed), robot.n_motors
    responses = []
    for motors, truth in zip(poses, exact):
        level = max(noise, 1e-9) * np.median(np.abs(np.einsum("fii->fi", truth)), axis=0)
        error = np.einsum("i,ij->ij", level**2, np.eye(n)) * np.ones((len(frequency), 1, 1)) + 0j
        circular = (rng.standard_normal(truth.shape) + 1j * rng.standard_normal(truth.shape)) / np.sqrt(2)
        responses.append(
            FrequencyResponse(
                frequency=frequency,
                response=truth + (noise > 0) * circular * level[:, None],
                noise_error=None,
                total_error=error,
                input_inverse=np.eye(n) * np.ones((len(frequency), 1, 1)) + 0j,
                degrees_of_freedom=50.0,
                input_names=robot.joint_names,
                output_names=robot.joint_names,
                input_units=("Nm",) * n,
                coordinate_units=("rad",) * n,
                gears=motors,
                motor_position=motors,
                sample_time=robot.sample_time,
                n_periods=2,
                n_blocks=10,
            )
        )
    return tuple(responses)


def springs_and_dampers(robot: Robot) -> list[str]:
    return [
        name
        for name, parameter in robot.parameters.items()
        if name.endswith(("stiffness", "damping")) and parameter.value > 0
    ]


@pytest.fixture(scope="session")
def e12() -> Robot:
    return load_robot("e12")


@pytest.fixture(scope="session")
def six_axis() -> Robot:
    return load_robot("six_axis")


@pytest.fixture(scope="session")
def e12_names(e12: Robot) -> list[str]:
    return springs_and_dampers(e12)


@pytest.fixture(scope="session")
def exact_e12(e12: Robot) -> tuple[FrequencyResponse, ...]:
    return measure(e12, E12_POSES, E12_FREQUENCY)


@pytest.fixture(scope="session")
def noisy_e12(e12: Robot) -> tuple[FrequencyResponse, ...]:
    return measure(e12, E12_POSES, E12_FREQUENCY, noise=3e-3)


@pytest.fixture(scope="session")
def six_axis_responses(six_axis: Robot) -> tuple[FrequencyResponse, ...]:
    return measure(six_axis, SIX_AXIS_POSES, SIX_AXIS_FREQUENCY, noise=1e-4)


@pytest.fixture(scope="session")
def measured() -> Measure:
    return measure


@pytest.fixture(scope="session")
def pendulum() -> Robot:
    """One motor and an arm without gravity: only the sum J + m x^2 = 6 + 3 kg m2 of the arm matters."""
    return robot_from_data(
        {
            "name": "pendulum",
            "sample_time": 1e-3,
            "sensors": {"encoder_noise": 1e-5},
            "bodies": [
                {
                    "mass": 12.0,
                    "center_of_mass": [0.5, 0, 0],
                    "inertia": {"zz": 6.0},
                    "length": [1, 0, 0],
                    "directions": {"rz": {"spring": 6e4, "damper": 30, "motor": {"inertia": 4.0}}},
                },
            ],
            "outputs": {"joints": {"coordinates": ["body_1.rz"]}},
            "controlled": "joints",
        },
        "test",
    )
