"""Checks of excitation, completeness, saturation and aliasing of a record."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.estimate.period_spectra import amplitudes

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.estimate.period_spectra import PeriodSpectra
    from flexros.identify.frf.experiments import Experiments
    from flexros.identify.frf.frequency_response import FrequencyResponse

LEAST_EXCITATION = 4.0
"""Smallest power of the torque at excited lines over that of its noise (6 dB; chosen)."""

ROUNDING = 1e-20
"""Power of the torque of an experiment over that of the strongest one, below which it counts as zero (chosen)."""

LEAST_PERIOD = 0.5
"""Least share of the mean excitation in every period (chosen)."""

MOST_SATURATED = 0.01
"""Largest share of samples at the torque limit that is accepted (chosen)."""

NEAR_NYQUIST = 0.8
"""Share of the Nyquist frequency above which lines and energy give a warning (chosen)."""

MOST_FOLDED = 0.01
"""Power near the Nyquist frequency over that at excited lines for a warning of folding (chosen)."""

LONGEST_PLATEAU = 3
"""Samples in a row at the extreme of a command from which it counts as saturated (chosen)."""


def check_periods(experiments: Experiments, spectra: PeriodSpectra) -> None:
    """Reject records of which a period or an experiment was not excited, or none was; each experiment by itself.

    Args:
        experiments: The samples.
        spectra: Their spectra at the excited lines among others.

    Raises:
        InputError: A period or an experiment is missing its excitation, or it does not stand out of the noise.
    """
    U = spectra.at(experiments.excited).input
    mean = U.mean(axis=1, keepdims=True)
    power = np.sum(abs(mean) ** 2, axis=(2, 3))
    _check_every_experiment(experiments, power[:, 0])
    share = np.sum((np.conj(mean) * U).real, axis=(2, 3)) / np.where(power > 0, power, 1.0)
    if experiments.n_periods > 1 and np.any(power > 0) and share.min() < LEAST_PERIOD:
        experiment, period = (int(place) for place in np.unravel_index(int(np.argmin(share)), share.shape))
        raise InputError(
            f"{experiments.label}: period {period + 1} of experiment {experiment + 1} is missing: it has "
            f"{share[experiment, period]:.2f} of the excitation of the mean period; record {experiments.n_periods} "
            "whole periods in steady state"
        )
    _check_above_noise(experiments, U)
    noise = _input_noise(experiments, spectra)
    for motor, name in enumerate(experiments.input_names):
        level = float(np.sum(abs(mean[..., motor]) ** 2))
        floor = 0.0 if noise is None else float(noise[motor])
        if level <= LEAST_EXCITATION * floor or level == 0.0:
            raise InputError(
                f"{experiments.label}: no excitation: the torque of {name} at the excited lines is not above its noise "
                f"(power ratio {level / floor if floor else 0.0:.2g}, needed is {LEAST_EXCITATION:g}); raise the "
                "amplitude"
            )


def _check_every_experiment(experiments: Experiments, power: FloatArray) -> None:
    """Reject experiments without excitation among others that have it; `power` has shape (m,)."""
    silent = np.flatnonzero(power <= ROUNDING * power.max())
    if len(silent) and power.max() > 0:
        raise InputError(
            f"{experiments.label}: no excitation: the torque of experiment {silent[0] + 1} of {len(power)} is zero at "
            "all excited lines; record the torque commands of every experiment"
        )


def _check_above_noise(experiments: Experiments, U: ComplexArray) -> None:
    """Reject experiments in which no motor torque exceeds its variation from period to period."""
    if experiments.n_periods < 2:
        return
    mean = U.mean(axis=1)
    floor = np.sum(abs(U - mean[:, None]) ** 2, axis=(1, 2)) / (experiments.n_periods * (experiments.n_periods - 1))
    drowned = np.all(np.sum(abs(mean) ** 2, axis=1) <= LEAST_EXCITATION * floor, axis=1)
    if np.any(drowned) and not np.all(drowned):
        raise InputError(
            f"{experiments.label}: no excitation: in experiment {int(np.argmax(drowned)) + 1} of {len(drowned)} no "
            f"torque at the excited lines is above its noise (needed is a power ratio of {LEAST_EXCITATION:g}); record "
            "the torque commands while the excitation runs"
        )


def _input_noise(experiments: Experiments, spectra: PeriodSpectra) -> FloatArray | None:
    """Return the noise power of the mean torque, summed over experiments and excited lines, shape (n_u,); or None.

    From the variation over periods, or with one period from the lines that were left out.
    """
    mine = spectra.at(experiments.excited).input
    if experiments.n_periods > 1:
        change = mine - mine.mean(axis=1, keepdims=True)
        scale = experiments.n_periods * (experiments.n_periods - 1)
        return np.asarray(np.sum(abs(change) ** 2, axis=(0, 1, 2)) / scale)
    rest = np.union1d(experiments.odd_detection, experiments.even_detection)
    if not len(rest):
        return None
    empty_lines = spectra.at(rest).input
    return np.asarray(np.sum(abs(empty_lines) ** 2, axis=(0, 1, 2)) * len(experiments.excited) / len(rest))


def check_reference(experiments: Experiments) -> list[str]:
    """Check the reference of non-periodic records, in which nothing else separates noise from excitation.

    Args:
        experiments: The samples.

    Returns:
        Warnings.

    Raises:
        InputError: The reference does not move.
    """
    if experiments.reference is None:
        return [
            f"{experiments.label}: the reference is not known; if noise alone excited the loop, the response would "
            "tend to minus the inverse of the controller"
        ]
    still = np.all(np.ptp(experiments.reference, axis=1) == 0, axis=0)
    if np.any(still):
        name = experiments.input_names[int(np.argmax(still))] if len(still) == len(experiments.input_names) else "it"
        raise InputError(
            f"{experiments.label}: no excitation: the reference of {name} does not move, so noise alone would be "
            "divided; record while the excitation runs"
        )
    return []


def check_saturation(experiments: Experiments, limits: FloatArray | None) -> list[str]:
    """Check for torques at their limit.

    Args:
        experiments: The samples.
        limits: Torque limits [Nm or N], shape (n_u,); None where they are not known: plateaus are looked for.

    Returns:
        Warnings of a small share, with which the response is usable: the command is what acted.

    Raises:
        InputError: A command is beyond its limit, so it did not act, or is at the limit for a large share.
    """
    warnings = []
    for motor, name in enumerate(experiments.input_names):
        torque = experiments.inputs[:, :, motor]
        limit = np.inf if limits is None else float(limits[motor])
        largest = float(np.max(abs(torque)))
        if largest > limit * (1 + 1e-6):
            raise InputError(
                f"{experiments.label}: saturated torque: {name} was commanded {largest:.4g}, beyond its limit of "
                f"{limit:.4g}, so the command is not what acted; lower the amplitude"
            )
        at_limit = _at_limit(torque, limit)
        share = float(np.mean(at_limit))
        if share > MOST_SATURATED:
            raise InputError(
                f"{experiments.label}: saturated torque: the command of {name} is at its limit of {largest:.4g} for "
                f"{share:.1%} of the record, allowed is {MOST_SATURATED:.0%}; lower the amplitude"
            )
        if share > 0:
            warnings.append(
                f"{experiments.label}: saturated torque: the command of {name} is at its limit of {largest:.4g} for "
                f"{share:.2%} of the record"
            )
    return warnings


def _at_limit(torque: FloatArray, limit: float) -> FloatArray:
    """Mark samples at the limit, and in plateaus at the largest or smallest value."""
    marks = np.asarray(abs(torque) >= limit * (1 - 1e-9), dtype=float)
    if np.ptp(torque) == 0:
        return marks
    for extreme in (torque.max(), torque.min()):
        reached = torque == extreme
        starts = max(reached.shape[1] - LONGEST_PLATEAU + 1, 0)
        if np.any(np.all([reached[:, k : k + starts] for k in range(LONGEST_PLATEAU)], axis=0)):
            marks[reached] = 1.0
    return marks


def check_aliasing(experiments: Experiments) -> list[str]:
    """Warn of lines and of periodic energy near the Nyquist frequency, which folds back.

    Args:
        experiments: The samples.

    Returns:
        Warnings.
    """
    half = experiments.period / 2
    if experiments.excited[-1] > NEAR_NYQUIST * half:
        return [
            f"{experiments.label}: aliasing: lines up to {experiments.frequency[-1]:g} Hz are excited, close to the "
            f"Nyquist frequency of {0.5 / experiments.sample_time:g} Hz; images of them fold back"
        ]
    if not experiments.periodic or experiments.n_periods < 2:
        return []
    high = np.arange(int(NEAR_NYQUIST * half), (experiments.period - 1) // 2 + 1)
    warnings = []
    folded, excited = _coherent_power(experiments, high), _coherent_power(experiments, experiments.excited)
    for motor, name in enumerate(experiments.input_names):
        if folded[motor] > MOST_FOLDED * excited[motor]:
            warnings.append(
                f"{experiments.label}: aliasing: the torque of {name} has {folded[motor] / excited[motor]:.1%} of its "
                "periodic power near the Nyquist frequency; content above it has been aliased"
            )
    return warnings


def _coherent_power(experiments: Experiments, lines: IntArray) -> FloatArray:
    """Return the power of the torque that repeats with the period, noise subtracted, shape (n_u,)."""
    P = experiments.n_periods
    U = np.array([amplitudes(samples, P, lines) for samples in experiments.inputs])
    mean = U.mean(axis=1)
    change = np.sum(abs(U - mean[:, None]) ** 2, axis=(0, 1, 2)) / (P * (P - 1))
    return np.asarray(np.sum(abs(mean) ** 2, axis=(0, 1)) - 2.0 * change)


def check_certainty(response: FrequencyResponse, label: str) -> list[str]:
    """Check a response against its standard deviation.

    Args:
        response: The estimate.
        label: Name of the record, for messages.

    Returns:
        A warning where diagonal entries are less than 6 dB above their standard deviation.

    Raises:
        InputError: Most of a diagonal is below it: there is nothing but noise.
    """
    kind = "total" if response.total_error is not None else "noise"
    if response.total_error is None and response.noise_error is None:
        return []
    n = min(response.response.shape[1:])
    size = abs(np.einsum("fii->fi", response.response[:, :n, :n]))
    deviation = np.einsum("fii->fi", response.standard_deviation(kind)[:, :n, :n])  # type: ignore[arg-type]
    poor = np.mean(size < deviation, axis=0)
    if poor.max() > 0.5:
        name = response.input_names[int(np.argmax(poor))]
        raise InputError(
            f"{label}: no excitation: the response of {name} to itself is below its standard deviation at "
            f"{poor.max():.0%} of the lines; raise the amplitude, or average over more periods and blocks"
        )
    weak = int(np.sum(np.any(size < 2.0 * deviation, axis=1)))
    if weak:
        return [f"{label}: at {weak} of {len(size)} lines a diagonal entry is less than 6 dB above its deviation"]
    return []
