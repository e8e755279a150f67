"""Indications of a model-form error, which biases parameters by more than their intervals state.

Intervals follow from the random errors of the responses. Friction, backlash or a missing flexibility change the
responses themselves: the best linear approximation differs from that of the model with the true parameters, and no
number of repetitions reveals it. Such effects have odd distortions in common; even ones of a few per mille come from
gravity and geometry and do not change the linear approximation (Pintelon and Schoukens 2012, chapter 3).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.scatter import ScatterLimits, power_ratio
from flexros.report.number_text import number, percent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.identify.frf.distortion import Distortion
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.covariance import ParameterCovariance
    from flexros.identify.graybox.problem import GrayBoxProblem
    from flexros.identify.graybox.residuals import ResidualReport

STANDS_OUT = 1.5
"""Smallest ratio of significant distortions to their noise, rms over lines and positions (chosen), if it exceeds what
few experiments and lines give by chance."""

MUCH = 0.01
"""Smallest significant even distortion relative to the output, rms (chosen)."""


def bias_signs(
    problem: GrayBoxProblem,
    covariance: ParameterCovariance,
    residuals: ResidualReport,
    limits: ScatterLimits | None = None,
    settled: bool = True,
) -> tuple[str, ...]:
    """Describe the indications.

    Args:
        problem: Measured responses.
        covariance: Covariance of the fitted parameters.
        residuals: Residuals of the fitted model.
        limits: Residuals explained by chance; default: as for many blocks.
        settled: Whether the fit converged within its bounds; otherwise its residuals are no evidence about the robot.

    Returns:
        One clause per indication; none where the robot is as linear as the model and the model explains its responses.
    """
    signs, limits = [], limits or ScatterLimits()
    reduced = covariance.reduced_cost if covariance.basis != "residuals" else 1.0
    if settled and reduced >= limits.cost:
        signs.append(f"the cost of the fit is {number(reduced, 2)} times what the errors of the responses explain")
    elif settled and residuals.chi_square >= limits.chi_square:
        signs.append(
            f"the squared misfit is {number(residuals.chi_square, 2)} times the variance of the responses, with equal "
            "weights of all lines"
        )
    levels = [response.distortion for response in problem.responses if response.distortion is not None]
    return (*signs, *_distorted(levels, problem.responses)) if levels else tuple(signs)


def _distorted(levels: Sequence[Distortion], responses: Sequence[FrequencyResponse]) -> list[str]:
    """Name the motors with the most significant distortions."""
    names = responses[0].output_names
    odd, even = (_over_noise(levels, kind, f"{kind}_noise") for kind in ("odd", "even"))
    signs = []
    if np.any(odd > _significant(responses, len(levels[0].odd_frequency))):
        worst = int(np.nanargmax(odd))
        signs.append(f"odd detection lines of {names[worst]} carry {number(odd[worst], 2)} times their noise")
    elif np.all(np.isnan(odd)):
        total = _over_noise(levels, "total", "noise")
        if np.any(total > _significant(responses, len(levels[0].frequency))):
            worst = int(np.nanargmax(total))
            ratio = number(total[worst], 2)
            signs.append(f"with the phases of the excitation responses of {names[worst]} vary {ratio} times the noise")
    share = np.where(even > _significant(responses, len(levels[0].even_frequency)), _share(levels), 0.0)
    if np.any(share > MUCH):
        worst = int(np.argmax(share))
        signs.append(f"even detection lines of {names[worst]} carry {percent(share[worst], 2)} % of the output")
    return signs


def _significant(responses: Sequence[FrequencyResponse], lines: int) -> float:
    """Smallest significant ratio of level to noise, for this number of lines."""
    experiments = sum(response.n_blocks * response.response.shape[2] for response in responses)
    spare = experiments * (responses[0].n_periods - 1)
    return max(STANDS_OUT, float(np.sqrt(power_ratio(experiments, spare, lines))))


def _over_noise(levels: Sequence[Distortion], level: str, noise: str) -> FloatArray:
    """Root of the mean over lines of power over noise, both summed over positions, shape (n_y,); NaN if not known."""
    power, floor = (sum(getattr(at_position, name) ** 2 for at_position in levels) for name in (level, noise))
    if not len(power):
        return np.full(power.shape[1], np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.sqrt(np.mean(power / np.where(floor > 0, floor, np.nan), axis=0)))


def _share(levels: Sequence[Distortion]) -> FloatArray:
    """Even distortions relative to the output at neighbouring lines, rms, shape (n_y,)."""
    if not len(levels[0].even):
        return np.zeros(levels[0].even.shape[1])
    shares = [
        np.stack(
            [at_position.even[:, motor] / np.interp(at_position.even_frequency, at_position.frequency, output)
             for motor, output in enumerate(at_position.output.T)]
        )
        for at_position in levels
    ]  # fmt: skip
    return np.asarray(np.sqrt(np.mean(np.square(shares), axis=(0, 2))))
