"""Accepted deviations of a robot: tails of its mean squares, estimated from a log, and their file.

No robot equals its model, and deviations grow with the motion. The mean squares of a log of normal operation define the
accepted level: noise plus shares of the mean squares of torques, speeds and accelerations. The logarithm of the ratio
to this level is modelled with an exponential tail above its 80 % quantile, which extrapolates to smaller probabilities
than the log contains (Pickands 1975). The decay is the slowest that so few values permit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field
from scipy.optimize import nnls

from flexros.atomic_file import write_result
from flexros.config.settings import Settings, validate
from flexros.config.text_file import read_json
from flexros.errors import InputError
from flexros.json_text import json_text
from flexros.monitor.sample_stream import WINDOW
from flexros.monitor.thresholds import LENGTHS

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.arrays import FloatArray

QUANTILE = 0.8
"""Quantile at which the tail begins (chosen)."""
FEWEST = 5.0
"""Fewest values without overlap for a tail; a length with fewer raises no alarm (chosen)."""
SURELY, LEAST_FALL = 2.0, 0.2
"""Standard deviations added to the decay, and its least value (chosen): other motions have other disturbances, and with
0.1 a further log of an accepted robot raised an alarm (tuned on development seeds)."""


class Tail(Settings):
    """Tail of the mean squares of one signal over one length."""

    begins: float = Field(description="logarithm of the mean square where it begins [1]")
    fall: float = Field(ge=0.0, description="excess of the logarithm at which it has fallen to 1/e [1]")
    share: float = Field(gt=0.0, le=1.0, description="share of the values beyond the beginning [1]")

    def level(self, chance: float) -> float:
        """Return the mean square that is exceeded with a probability."""
        return float(np.exp(min(self.begins + self.fall * max(np.log(self.share / chance), 0.0), 600.0)))


class Calibration(Settings):
    """Tails of all signals and lengths."""

    schema_version: int = Field(1, ge=1, le=1, description="version of this format [1]")
    model: str = Field(description="fingerprint of the model")
    robot: str = Field(description="name of its robot")
    log: str = Field(description="log that it was estimated from")
    time: float = Field(gt=0.0, description="time of the log that was monitored [s]")
    accepted: dict[str, float] = Field(
        description="rms of the disturbance torque over that of noise by joint, median [1]"
    )
    growth: dict[str, list[float]] = Field(
        description="by signal: increase per unit of the mean squares of torques, speeds and accelerations [1/SI]"
    )
    tails: dict[str, list[Tail | None]] = Field(
        description="by signal: tails for the lengths; null where the log was too short"
    )

    def expected(self, motion: FloatArray) -> FloatArray:
        """Return the accepted mean squares for a motion.

        Args:
            motion: Mean squares of torques, speeds and accelerations [SI], shape (..., 3 M).

        Returns:
            Mean squares over those of noise [1], shape (..., 2 M).
        """
        return np.asarray(1.0 + motion @ np.array(list(self.growth.values())).T)

    def levels(self, chances: FloatArray) -> FloatArray:
        """Return the mean squares, over the accepted ones, of given probabilities.

        Args:
            chances: Probability for each length, shape (3,).

        Returns:
            Levels, infinite where the log was too short, shape (3, signals).
        """
        columns = [
            [np.inf if tail is None else tail.level(chance) for tail, chance in zip(tails, chances.tolist())]
            for tails in self.tails.values()
        ]
        return np.array(columns).T


def calibrate(
    values: FloatArray, motion: FloatArray, names: tuple[str, ...], *, model: str, robot: str, log: str
) -> Calibration:
    """Estimate the tails from a log.

    Args:
        values: Mean squares of innovations, then of disturbance torques, by window [1], shape (windows, 2 M).
        motion: Mean squares of torques, speeds and accelerations by window [SI], shape (windows, 3 M).
        names: Names of the motors, length M.
        model: Fingerprint of the model.
        robot: Name of its robot.
        log: Name of the log.

    Raises:
        InputError: The log is too short.
    """
    needed = FEWEST * LENGTHS[1]
    if len(values) < needed:
        raise InputError(
            f"{log}: {len(values) * WINDOW:.1f} s of it could be monitored, at least {needed * WINDOW:g} s are needed "
            "to set thresholds; record normal operation for some minutes"
        )
    M = len(names)
    signals = [f"{name}.sudden" for name in names] + [f"{name}.torque" for name in names]
    growth = {signal: _growth(column, motion).tolist() for signal, column in zip(signals, values.T)}
    expected = 1.0 + motion @ np.array(list(growth.values())).T
    relative = values / expected
    tails = {signal: [_tail(column, length) for length in LENGTHS] for signal, column in zip(signals, relative.T)}
    accepted = {name: float(np.sqrt(np.median(column))) for name, column in zip(names, values[:, M:].T)}
    return Calibration(
        model=model, robot=robot, log=log, time=len(values) * WINDOW, accepted=accepted, growth=growth, tails=tails
    )


def _growth(column: FloatArray, motion: FloatArray) -> FloatArray:
    """Fit mean squares by non-negative shares of those of the motion, with errors relative to their size."""
    unit = np.maximum(motion.max(axis=0), 1e-300)
    weight = 1 / (1 + column)
    shares = nnls((motion / unit) * weight[:, None], np.maximum(column - 1, 0.0) * weight)[0]
    return np.asarray(shares / unit)


def _tail(column: FloatArray, length: int) -> Tail | None:
    """Estimate the tail of overlapping means over a length."""
    apart = len(column) / length
    if apart < FEWEST:
        return None
    sums = np.concatenate([[0.0], np.cumsum(column)])
    logarithm = np.log(np.maximum((sums[length:] - sums[:-length]) / length, 1e-300))
    begins = float(np.quantile(logarithm, QUANTILE))
    beyond = logarithm[logarithm > begins] - begins
    fewer = max(apart * (1 - QUANTILE), 1.0)
    fall = float(beyond.mean()) * (1 + SURELY / np.sqrt(fewer)) if beyond.size else 0.0
    return Tail(begins=begins, fall=max(fall, LEAST_FALL), share=1 - QUANTILE)


def write_calibration(path: Path, calibration: Calibration) -> None:
    """Write a calibration.

    Raises:
        InputError: It cannot be written there.
    """
    write_result(path, json_text(calibration.model_dump(mode="json")), "calibration")


def read_calibration(path: Path, model: str, names: tuple[str, ...]) -> Calibration:
    """Read a calibration.

    Args:
        path: The file.
        model: Fingerprint of the monitored model.
        names: Names of its motors.

    Raises:
        InputError: It cannot be read, or belongs to another model.
    """
    try:
        content = read_json(path)
    except InputError as error:
        raise InputError(
            f"the calibration {path} cannot be read ({error}); calibrate the monitor by an accepted log", "thresholds"
        ) from error
    if not isinstance(content, dict):
        raise InputError(
            f"the calibration {path} is no JSON object; calibrate the monitor by an accepted log", "thresholds"
        )
    calibration = validate(Calibration, content, str(path))
    wanted = {f"{name}.{signal}" for name in names for signal in ("sudden", "torque")}
    whole = set(calibration.tails) == wanted and all(len(tails) == len(LENGTHS) for tails in calibration.tails.values())
    whole &= set(calibration.growth) == wanted and all(
        len(shares) == 3 * len(names) for shares in calibration.growth.values()
    )
    if calibration.model != model or not whole:
        raise InputError(
            f"the calibration {path} was made for robot {calibration.robot} with fingerprint {calibration.model}, but "
            f"the model has {model}; calibrate the monitor again",
            "thresholds",
        )
    return calibration
