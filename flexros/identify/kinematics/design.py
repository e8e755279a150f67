"""The most informative poses and loads for the unknowns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.design.candidates import default_ranges
from flexros.identify.kinematics.elastostatics import measured_points
from flexros.identify.kinematics.record import PoseRecord

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.kinematics.unknowns import Unknowns

CANDIDATES = 400
"""Poses to choose from (chosen)."""


def candidate_poses(unknown: Unknowns, loads: Sequence[float], number: int = CANDIDATES, seed: int = 1) -> PoseRecord:
    """Draw poses over the ranges of the motors, with each of the loads in turn; the tool is not measured (zero).

    Args:
        unknown: The unknowns.
        loads: Masses at the tool [kg].
        number: Number of poses.
        seed: Seed of the draw.
    """
    ranges = default_ranges(unknown.robot)
    motors = np.random.default_rng(seed).uniform(ranges[:, 0], ranges[:, 1], (number, unknown.robot.n_motors))
    return PoseRecord(motors, np.resize(np.asarray(loads, dtype=float), number), np.zeros((number, 3)))


def optimal_poses(unknown: Unknowns, candidates: PoseRecord, number: int, noise: float) -> IntArray:
    """Choose poses by the largest determinant of the information, one after the other, then by exchange.

    Args:
        unknown: The unknowns.
        candidates: Poses to choose from.
        number: Number of poses.
        noise: Noise of each measured coordinate, rms [m].

    Returns:
        Indices of the chosen candidates, shape (number,).

    Raises:
        InputError: More poses than candidates.
    """
    if not 4 <= number <= len(candidates):
        raise InputError(f"{number} poses are to be chosen from {len(candidates)}; allowed are 4 to all of them")
    _, slopes = measured_points(unknown, candidates, np.zeros(len(unknown.names)))
    scaled = slopes * unknown.deviation / noise
    chosen: list[int] = []
    covariance: FloatArray = np.eye(len(unknown.names))
    while len(chosen) < number:
        gains = _gains(scaled, covariance)
        gains[chosen] = -np.inf
        chosen.append(int(np.argmax(gains)))
        covariance = _covariance(scaled, chosen)
    for place in range(number):  # one exchange of each
        rest = [pose for k, pose in enumerate(chosen) if k != place]
        covariance = _covariance(scaled, rest)
        gains = _gains(scaled, covariance)
        gains[rest] = -np.inf
        chosen[place] = int(np.argmax(gains))
    return np.array(chosen)


def _covariance(scaled: FloatArray, chosen: list[int]) -> FloatArray:
    J = scaled[chosen].reshape(-1, scaled.shape[2])
    return np.asarray(np.linalg.inv(np.eye(J.shape[1]) + J.T @ J), dtype=np.float64)


def _gains(scaled: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return log det(1 + J C J^T) of each candidate, shape (n,)."""
    inner = np.eye(3) + np.einsum("nip,pq,njq->nij", scaled, covariance, scaled)
    return np.asarray(np.linalg.slogdet(inner)[1])
