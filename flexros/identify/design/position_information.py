"""Information that a block of experiments would give in each of many positions, predicted by the nominal model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.control.context import LoopContext
from flexros.identify.design.closed_loop_input import ExperimentConditions, input_spectrum, output_error
from flexros.identify.design.information import frf_information
from flexros.identify.experiment.closed_loop_response import controller_response
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.robot.linear.positions import linearise_positions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.identify.experiment.specification import IdentificationSpecification
    from flexros.robot import Robot

MOST_LINES = 60
"""Excited lines to compute at most; more are represented by neighbours (chosen)."""
_CHUNK = 32
"""Positions computed at once (chosen; some 100 MB for 26 parameters and six motors)."""


def experiment_conditions(
    specification: IdentificationSpecification,
    robot: Robot,
    sample_time: float,
    seed: int,
    most_lines: int = MOST_LINES,
    distortion: float = 0.0,
) -> ExperimentConditions:
    """Collect what a block of experiments is like in every position.

    Args:
        specification: The experiment.
        robot: The robot, for its encoder noise.
        sample_time: Time between two samples [s].
        seed: Seed of the excitation.
        most_lines: Largest number of lines to compute.
        distortion: Expected level of nonlinear distortions at the output relative to its own, rms [1].

    Returns:
        Lines, amplitudes and noise.

    Raises:
        InputError: The excitation does not suit sample time or motors.
    """
    excitation = specification.excitation
    n_samples = excitation.record_samples(sample_time)
    excited = excitation.lines(sample_time, seed).excited
    chosen = excited[np.unique(np.linspace(0, len(excited) - 1, min(most_lines, len(excited))).round().astype(int))]
    speed = excitation.block(robot.n_motors, sample_time, seed, 0, 0).speed
    spectrum = 2 / n_samples * np.fft.rfft(speed, axis=1)[:, chosen]
    return ExperimentConditions(
        frequency=chosen / (n_samples * sample_time),
        amplitude=np.sqrt(np.mean(np.abs(spectrum) ** 2, axis=0)),
        encoder_variance=4 * robot.encoder_noise**2 / (n_samples * specification.periods),
        share=len(excited) / len(chosen),
        distortion=distortion,
    )


def position_information(
    robot: Robot,
    names: Sequence[str],
    motor_positions: FloatArray,
    conditions: ExperimentConditions,
    law: AbstractControlLaw,
    sample_time: float,
    progress: Callable[[int], None] | None = None,
) -> FloatArray:
    """Predict the information of one block in each position about the logarithms of parameters.

    Args:
        robot: The robot with its nominal values.
        names: Names of the unknown parameters, length P.
        motor_positions: Motor positions [rad or m], shape (Q, M).
        conditions: The excitation and its noise.
        law: Controller of the experiment.
        sample_time: Time between two samples [s].
        progress: Called with the number of positions done.

    Returns:
        Information, shape (Q, P, P).
    """
    chunks = []
    for part in _by_frequency(robot, names, motor_positions, conditions, law, sample_time):
        chunks.append(conditions.share * part.sum(axis=1))
        if progress is not None:
            progress(sum(map(len, chunks)))
    return np.concatenate(chunks)


def frequency_information(
    robot: Robot,
    names: Sequence[str],
    motor_positions: FloatArray,
    conditions: ExperimentConditions,
    law: AbstractControlLaw,
    sample_time: float,
) -> FloatArray:
    """Predict the same at each frequency; see `position_information`.

    Returns:
        Information of each line, shape (Q, F, P, P).
    """
    return np.concatenate(list(_by_frequency(robot, names, motor_positions, conditions, law, sample_time)))


def _by_frequency(
    robot: Robot,
    names: Sequence[str],
    motor_positions: FloatArray,
    conditions: ExperimentConditions,
    law: AbstractControlLaw,
    sample_time: float,
) -> Iterator[FloatArray]:
    """Yield the information of some positions at a time, shape (q, F, P, P)."""
    controller = controller_response(law, LoopContext(robot, sample_time), conditions.frequency)
    for begin in range(0, len(motor_positions), _CHUNK):
        positions = linearise_positions(robot, names, motor_positions[begin : begin + _CHUNK])
        model = FrequencyModel(positions, conditions.frequency, sample_time, robot.delay)
        response, jacobian = model.response_and_jacobian(positions.values)
        spectrum = input_spectrum(response, conditions, controller)
        yield frf_information(jacobian, spectrum, output_error(response, spectrum, conditions))
