"""What a robot misses as it is accepted: tails of its mean squares, read off a log, and their file.

No robot is exactly as its model, and the more it does the more the model misses. The mean squares of a log of normal
work are taken as what is accepted: as noise plus shares of the mean squares of torques, speeds and accelerations.
Over that sum their logarithm is taken to fall off exponentially above its 80 % quantile, which tells levels for rarer
chances than the log shows (Pickands 1975). The fall is taken as slow as so few values permit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field
from scipy.optimize import nnls

from flexros.config.settings import Settings, validate
from flexros.config.text_file import read_json
from flexros.errors import InputError
from flexros.json_text import json_text
from flexros.monitor.sample_stream import WINDOW
from flexros.monitor.thresholds import LENGTHS
from flexros.whole_file import write_result

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.arrays import FloatArray

QUANTILE = 0.8
"""Share of the values below which the tail begins (chosen)."""
FEWEST = 5.0
"""Fewest values that do not overlap from which a tail is told; below, that length raises no alarm (chosen)."""
SURELY, LEAST_FALL = 2.0, 0.2
"""Standard deviations of the fall that are added to it; its least value, as other motions miss other torques: with
0.1 a further log of a robot as accepted raised an alarm (development seeds)."""


class Tail(Settings):
    """Tail of the mean squares of one signal over one length."""

    begins: float = Field(description="logarithm of the mean square where it begins [1]")
    fall: float = Field(ge=0.0, description="excess of the logarithm at which it has fallen to 1/e [1]")
    share: float = Field(gt=0.0, le=1.0, description="share of the values beyond the beginning [1]")

    def level(self, chance: float) -> float:
        """Give the mean square that is exceeded with a probability."""
        return float(np.exp(min(self.begins + self.fall * max(np.log(self.share / chance), 0.0), 600.0)))


class Calibration(Settings):
    """Tails of all signals and lengths."""

    schema_version: int = Field(1, ge=1, le=1, description="version of this form [1]")
    model: str = Field(description="fingerprint of the model")
    robot: str = Field(description="name of its robot")
    log: str = Field(description="log that it was read off")
    time: float = Field(gt=0.0, description="time of the log that was watched [s]")
    accepted: dict[str, float] = Field(description="rms of missing torque over that of noise by joint, median [1]")
    growth: dict[str, list[float]] = Field(
        description="by signal: what a unit of the mean squares of torques, speeds and accelerations adds [1/SI]"
    )
    tails: dict[str, list[Tail | None]] = Field(
        description="by signal: tails for the lengths; null where the log was too short"
    )

    def expected(self, motion: FloatArray) -> FloatArray:
        """Give the mean squares that are accepted while the robot does so much.

        Args:
            motion: Mean squares of torques, speeds and accelerations [SI], shape (..., 3 M).

        Returns:
            Mean squares over those of noise [1], shape (..., 2 M).
        """
        return np.asarray(1.0 + motion @ np.array(list(self.growth.values())).T)

    def levels(self, chances: FloatArray) -> FloatArray:
        """Give the mean squares, over those that are expected, of given probabilities.

        Args:
            chances: Probability for each length, shape (3,).

        Returns:
            Levels, infinite where nothing is known, shape (3, signals).
        """
        columns = [
            [np.inf if tail is None else tail.level(chance) for tail, chance in zip(tails, chances.tolist())]
            for tails in self.tails.values()
        ]
        return np.array(columns).T


def calibrate(
    values: FloatArray, motion: FloatArray, names: tuple[str, ...], *, model: str, robot: str, log: str
) -> Calibration:
    """Read the tails off a log.

    Args:
        values: Mean squares of all windows, sudden parts then missing torques, shape (windows, 2 M).
        motion: What the robot did in them, shape (windows, 3 M).
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
            f"{log}: {len(values) * WINDOW:.1f} s of it could be watched, needed are {needed * WINDOW:g} s to set "
            f"thresholds; record a log of normal work, best some minutes"
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
    """Fit mean squares by shares of what the robot does, none below zero, with errors relative to their size."""
    unit = np.maximum(motion.max(axis=0), 1e-300)
    weight = 1 / (1 + column)
    shares = nnls((motion / unit) * weight[:, None], np.maximum(column - 1, 0.0) * weight)[0]
    return np.asarray(shares / unit)


def _tail(column: FloatArray, length: int) -> Tail | None:
    """Take the tail of means over a length, which overlap."""
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
        model: Fingerprint of the model that is watched.
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
    found = validate(Calibration, content, str(path))
    wanted = {f"{name}.{signal}" for name in names for signal in ("sudden", "torque")}
    whole = set(found.tails) == wanted and all(len(one) == len(LENGTHS) for one in found.tails.values())
    whole &= set(found.growth) == wanted and all(len(one) == 3 * len(names) for one in found.growth.values())
    if found.model != model or not whole:
        raise InputError(
            f"the calibration {path} was made for robot {found.robot} with fingerprint {found.model}, but the model "
            f"has {model}; calibrate the monitor again",
            "thresholds",
        )
    return found
