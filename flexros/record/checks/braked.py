"""Stretches of a real machine in which no drive is on and brakes hold the arm: they do not count."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.feedforward.rigid_arm import rigid_arm
from flexros.record.missing_samples import LEAST_STRETCH, runs
from flexros.record.prescribed_motion import without_prescribed

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record
    from flexros.robot import Robot

HELD = 0.01
"""Range of the position of a joint over the way that the weight alone would move it, below which something holds it [1]
(chosen): a drive that is off cannot, and friction that could would be much of the torque of slow moves."""

HEAVY = 0.05
"""Weight at a joint over the rms of its torque elsewhere, above which it shows [1]: the share within which measured
torques count as known."""


def without_braked_rests(record: Record, robot: Robot) -> Record:
    """Return a record in which stretches do not count where all torques are exactly zero and the arm does not fall.

    A drive that is switched off notes no torque at all. Where the arm rests then although its weight would move it,
    brakes carry the weight: a model without them falls, and effects would be named for that. Of pauses between joined
    runs, in which nothing was measured, the reading tells: only samples beside them are counted.

    Args:
        record: The log.
        robot: The nominal robot.
    """
    torque = without_prescribed(record).torque
    if not record.imported or record.command is not None or not np.any(torque):
        return record
    known = HEAVY * np.sqrt(np.mean(torque[np.any(torque, axis=1)] ** 2, axis=0))
    known[~np.any(torque, axis=0)] = np.inf  # no drive, and no brake: what shows is the zero of its encoder
    braked = np.zeros(record.n_samples, dtype=bool)
    for begin, length in zip(*runs(~np.any(torque, axis=1)), strict=True):
        rows = int(begin) + np.flatnonzero(record.valid[begin : begin + length])
        duration = len(rows) * record.sample_time
        if length >= LEAST_STRETCH and len(rows) and _held(robot, record.position[rows], duration, known):
            braked[rows] = True
    if not braked.any():
        return record
    count = braked.sum() * record.sample_time
    warning = (
        f"all torques are exactly zero for {count:.3g} s, the first time at "
        f"{float(np.argmax(braked)) * record.sample_time:.4g} s, although the weight of the arm would move it there: "
        "its drives are off and brakes hold it; these samples do not count"
    )
    return replace(record, valid=record.valid & ~braked, warnings=(*record.warnings, warning))


def _held(robot: Robot, position: FloatArray, duration: float, known: FloatArray) -> bool:
    """Return whether no joint moves that its weight alone would move from rest.

    Args:
        robot: The nominal robot.
        position: Positions [rad or m], shape (n, M).
        duration: Time without torque [s].
        known: Weight at each joint up to which it may be balanced [Nm or N], shape (M,).
    """
    pose = position.mean(axis=0)
    still = np.zeros((3, 1 + len(pose), len(pose)))
    still[0] = pose
    still[2, 1:] = np.eye(len(pose))
    torque = rigid_arm(robot).inverse_dynamics(still).torque
    weight, inertia = torque[0], np.diag(torque[1:] - torque[0])
    falling = np.where(np.abs(weight) > known, np.abs(weight), 0.0) / np.maximum(inertia, np.finfo(float).tiny)
    way = falling * duration**2 / 2
    carrying = way > 0
    return bool(carrying.any() and np.all(np.ptp(position, axis=0)[carrying] < HELD * way[carrying]))
