"""Check for delays between torque and motion beyond the delay of the nominal robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.checks.nominal_level import FEWEST_LINES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import BoolArray, ComplexArray, FloatArray
    from flexros.identify.frf.checks.nominal_level import NominalDiagonal
    from flexros.identify.frf.frequency_response import FrequencyResponse

LONGEST_DELAY = 5e-3
"""Delay in addition to that of the model above which a response is rejected [s] (chosen)."""

SEARCHED = 0.05
"""Longest delay of the search [s] (chosen)."""

NOTED_DELAY = 0.25
"""Delay for a warning [samples] (chosen)."""

SIGNIFICANT = 4.0
"""Delay over its standard deviation above which it is significant (chosen)."""

ALONE = 2.0
"""Factor on length and significance for the delay of a single motor, since motors usually share one (chosen)."""

LEAST_SPREAD = 2e-5
"""Standard deviation added to that of every delay, because the model is not exact [s] (chosen)."""

COHERENT = 0.9
"""Least share of the response that a pure delay must explain (chosen)."""

LARGEST_DEVIATION = 0.5
"""Relative deviation of a response above which its phase is not used (chosen)."""

SAME_LEVEL = 0.5
"""Distance of the logarithm of a magnitude from the median above which its phase is not used (chosen)."""

LEAST_DEVIATION = 0.01
"""Standard deviation added to that of every phase, because the model is not exact [rad] (chosen)."""


def delays(response: FrequencyResponse, nominal: NominalDiagonal) -> FloatArray:
    """Estimate the delay of every motor with respect to the nominal robot, with its standard deviation.

    The phase between measured and nominal response at mass-like lines is fitted by -w tau + c / w: a delay, and the
    error of a damper. Of the plausible springs and dampers, those that fit best are used.

    Args:
        response: Measured response.
        nominal: Nominal response at the same lines.

    Returns:
        Delay and its standard deviation [s], shape (2, M); NaN where too few lines are mass-like.
    """
    own = np.einsum("fii->fi", response.as_quantity("acceleration").response)
    deviation = _relative_deviation(response, own)
    found = np.full((2, own.shape[1]), np.nan)
    for motor in range(own.shape[1]):
        fits = []
        for model, like in zip(nominal.response[:, :, motor], nominal.mass_like[:, :, motor], strict=True):
            ratio = own[:, motor] / model
            lines = like & (deviation[:, motor] < LARGEST_DEVIATION) & _same_level(ratio)
            if lines.sum() >= FEWEST_LINES:
                fits.append(_delay(response.frequency[lines], ratio[lines], deviation[lines, motor]))
        found[:, motor] = _together(np.array([fit for fit in fits if np.isfinite(fit[0])]))
    return found


def _same_level(ratio: ComplexArray) -> BoolArray:
    """Mark the lines where a ratio has the level of most lines; elsewhere resonances or noise determine its phase."""
    level = np.log(np.maximum(abs(ratio), 1e-300))
    return np.asarray(abs(level - np.median(level)) < SAME_LEVEL)


def _together(fits: FloatArray) -> tuple[float, float]:
    """Return the delay that fits best; the others, by their weight, widen its deviation. `fits` has shape (S, 2)."""
    if not len(fits):
        return np.nan, np.nan
    best = fits[np.argmin(fits[:, 1])]
    weight = (best[1] / fits[:, 1]) ** 2
    spread = np.sum(weight * (fits[:, 0] - best[0]) ** 2) / np.sum(weight)
    return float(best[0]), float(np.sqrt(best[1] ** 2 + spread))


def check_delay(found: FloatArray, names: Sequence[str], label: str) -> None:
    """Reject a response of which all motors have a long delay; that of one alone looks like an inverted sign.

    Args:
        found: Delay and deviation [s], shape (2, M).
        names: Names of the motors, length M.
        label: Name of the record, for messages.

    Raises:
        InputError: The delay is longer than LONGEST_DELAY.
    """
    common = _common(found)
    if significant(common, LONGEST_DELAY)[0]:
        raise InputError(
            f"{label}: {', '.join(names)}: {_delay_text(common[0, 0])}, allowed are {1e3 * LONGEST_DELAY:g} ms; give "
            "time_offset in the mapping file so that command and measurement of the same instant have the same stamp"
        )


def delay_warnings(found: FloatArray, names: Sequence[str], sample_time: float) -> list[str]:
    """Warn of delays that all positions together show: of all motors, else of single ones.

    Args:
        found: Delay and deviation of every position [s], shape (Q, 2, M).
        names: Names of the motors, length M.
        sample_time: T_s [s].

    Returns:
        One sentence per delay.
    """
    motors = np.stack([_common(found[:, :, motor].T)[:, 0] for motor in range(len(names))], axis=1)
    common = _common(motors)
    if significant(common, NOTED_DELAY * sample_time)[0]:
        delayed = [(", ".join(names), common[0, 0])]
    else:
        sure = significant(motors * np.array([[1.0], [ALONE]]), ALONE * NOTED_DELAY * sample_time)
        delayed = [(name, tau) for name, tau, is_sure in zip(names, motors[0], sure, strict=True) if is_sure]
    return [
        f"{name}: {_delay_text(tau)}; give time_offset in the mapping file or delay in the robot file"
        for name, tau in delayed
    ]


def _common(found: FloatArray) -> FloatArray:
    """Return the weighted mean of delays and the deviation of one of them [s], shapes (2, n) -> (2, 1).

    The errors of a model are common to many of them, so that averaging does not reduce them.
    """
    tau, spread = found[:, ~np.isnan(found[0])]
    if not len(tau):
        return np.full((2, 1), np.nan)
    variance = spread**2 + LEAST_SPREAD**2
    share = 1 / variance / np.sum(1 / variance)
    mean = float(share @ tau)
    return np.array([[mean], [np.sqrt(float(share @ (variance + (tau - mean) ** 2)))]])


def significant(found: FloatArray, shortest: float) -> BoolArray:
    """Mark significant delays longer than `shortest` [s], shape (M,)."""
    with np.errstate(invalid="ignore"):
        return np.asarray((abs(found[0]) > shortest) & (abs(found[0]) > SIGNIFICANT * found[1]))


def undelayed(response: ComplexArray, frequency: FloatArray, found: FloatArray) -> ComplexArray:
    """Remove significant delays from the columns of a response, so that its signs can be compared.

    Args:
        response: Shape (F, M, M).
        frequency: Frequencies [Hz], shape (F,).
        found: Delay and deviation [s], shape (2, M).
    """
    tau = np.where(significant(found, 0.0), found[0], 0.0)
    return np.asarray(response * np.exp(2j * np.pi * frequency[:, None] * tau)[:, None, :])


def _delay_text(tau: float) -> str:
    amount = f"{1e3 * abs(tau):.2g} ms"
    if tau > 0:
        return f"the torque leads the motion by {amount} more than the delay of the model says"
    return f"the torque is stamped {amount} too late against the motion and the delay of the model"


def _relative_deviation(response: FrequencyResponse, own: ComplexArray) -> FloatArray:
    """Return the standard deviation of the phases [rad], shape (F, M)."""
    for kind, error in (("total", response.total_error), ("noise", response.noise_error)):
        if error is not None:
            deviation = response.as_quantity("acceleration").standard_deviation(kind)  # type: ignore[arg-type]
            return np.asarray(np.einsum("fii->fi", deviation).real / np.maximum(abs(own), 1e-300))
    return np.zeros(own.shape)


def _delay(frequency: FloatArray, ratio: ComplexArray, deviation: FloatArray) -> tuple[float, float]:
    """Fit the phase of a ratio; return delay and deviation [s], NaN where a delay does not explain it."""
    omega = 2 * np.pi * frequency
    weight = 1 / (deviation**2 + LEAST_DEVIATION**2)
    unit = ratio / np.maximum(abs(ratio), 1e-300)
    steps = np.arange(-SEARCHED, SEARCHED, 0.1 / frequency[-1])
    sums = np.exp(1j * np.outer(steps, omega)) @ (weight * unit) / weight.sum()
    best = int(np.argmax(abs(sums)))
    if abs(sums[best]) < COHERENT:
        return np.nan, np.nan
    sign = 1.0 if sums[best].real >= 0 else -1.0
    rest = np.angle(sign * unit * np.exp(1j * omega * steps[best]))
    root = np.sqrt(weight)[:, None]
    regressors = np.stack([-omega, 1 / omega], axis=1)
    scale = np.linalg.norm(root * regressors, axis=0)
    matrix = root * regressors / scale
    solution, *_ = np.linalg.lstsq(matrix, root[:, 0] * rest, rcond=None)
    error = root[:, 0] * rest - matrix @ solution
    variance = np.linalg.inv(matrix.T @ matrix)[0, 0] * max(1.0, float(error @ error) / (len(rest) - 2))
    return float(steps[best] + solution[0] / scale[0]), float(np.sqrt(variance) / scale[0])
