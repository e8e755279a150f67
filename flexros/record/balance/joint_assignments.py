"""Alternative joint assignments of a record: a joint inverted, or two exchanged."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.balance.spectra import torque_balance
from flexros.robot.parameters import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.arrays import FloatArray
    from flexros.record.balance.torque_balance import Agreement, BalanceFit, TorqueBalance
    from flexros.record.record import Record
    from flexros.robot import Robot

DOUBTFUL = 0.9
"""Mean agreement below which other assignments are tried (chosen)."""

GAIN, REST = 0.1, 0.4
"""Least gain of the mean agreement, and largest remaining share of the disagreement, of an assignment that is accepted
(chosen)."""

LEAST = 0.01
"""Least gain of the mean agreement by the inversion of a further axis (chosen)."""

HINT = 0.2
"""Least gain of the mean agreement, and more than twice it, from which an assignment is worth a warning (chosen)."""

ALIKE, LISTED = 0.003, 2
"""Difference of the mean agreement up to which assignments fit alike, and how many of them are told beside the first
(chosen): turning a wrist by 180 degrees and counting the next axis the other way is the same motion."""

WEIGHTLESS = dict.fromkeys(GRAVITY, 0.0)
"""Parameters of a robot without gravity."""

RIGHT_ANGLES = (90.0, -90.0, 180.0)
"""Differences between the zeros of two models of a robot that are tried [deg]."""

LONG = 16.0
"""Length of the part of a record by which the assignments of many motors are compared [s] (chosen)."""

FEW = 3
"""Most motors for which the whole record is used (chosen)."""


@dataclass(frozen=True)
class JointAssignment:
    """An alternative assignment of columns and signs to the joints of a record.

    Attributes:
        text: The error of the log if this assignment is right.
        agreement: Mean agreement of torques and inverse-dynamics torques.
        opposite: Whether torque and position of a joint have opposite directions otherwise, which no parameters of a
            robot explain.
        clear: Whether it fits so much better that no effect explains the difference.
        zeros: Whether it adds angles to positions, which a base that is mounted otherwise may look like.
        exchanged: Motors that it exchanges; none where it exchanges none.
    """

    text: str
    agreement: float
    opposite: bool
    clear: bool = True
    zeros: bool = False
    exchanged: tuple[int, ...] = ()


def own_fits(balance: TorqueBalance | None, n_motors: int) -> tuple[BalanceFit | None, ...]:
    """Compare the torque of every motor with the inverse-dynamics torque of its own motion.

    Args:
        balance: Spectra of both; None where there are none.
        n_motors: Number of motors M.

    Returns:
        Comparisons, length M; None where the motion is not clear of noise.
    """
    return tuple(None if balance is None else balance.fit(k, k) for k in range(n_motors))


def own_score(balance: TorqueBalance | None, n_motors: int) -> float | None:
    """Average the agreement of every motor with its own motion, as `score` of `own_fits`, without what they add.

    Args:
        balance: Spectra of both; None where there are none.
        n_motors: Number of motors M.

    Returns:
        The mean; None where no motor has one.
    """
    return score([None if balance is None else balance.agreement(k, k) for k in range(n_motors)])


def score(fits: Sequence[Agreement | None]) -> float | None:
    """Average the agreement of torques and inverse-dynamics torques over the motors that have one.

    Args:
        fits: Comparison of every motor.

    Returns:
        The mean; None where no motor has one.
    """
    agreements = [max(fit.as_is, -1.0) for fit in fits if fit is not None]
    return float(np.mean(agreements)) if agreements else None


def clearly_better(other: float | None, current: float | None) -> bool:
    """Return whether a mean agreement is so much better that no effect explains the difference.

    Args:
        other: Mean agreement of the alternative; None where it is unknown.
        current: Mean agreement of the record as it is.
    """
    if other is None or current is None:
        return False
    return other > current + GAIN and 1 - other < REST * (1 - current)


def best_assignment(record: Record, robot: Robot, current: float | None) -> JointAssignment | None:
    """Find an assignment that fits clearly better than the record as it is.

    Args:
        record: The record.
        robot: The nominal robot.
        current: Mean agreement of the record as it is.

    Returns:
        The best one that fits clearly better, else one that fits much better than badly; None where the record fits
        well, or there is none.
    """
    if current is None or current > DOUBTFUL:
        return None
    if robot.n_motors > FEW and record.duration > LONG:
        record = _most_active_part(record, round(LONG / record.sample_time))
        current = own_score(torque_balance(record, robot), robot.n_motors)
    others = [*_assignments(record, robot), *_axes_inverted(record, robot), *_zeros_elsewhere(record, robot)]
    others += _weightless(record, robot)
    better = [other for other in others if clearly_better(other.agreement, current)]
    if better:
        return _first_of_alike(better)
    if not others or current is None:
        return None
    best = _first_of_alike(others)
    return None if best.agreement < max(current + HINT, 2 * current) else replace(best, clear=False)


def _first_of_alike(others: Sequence[JointAssignment]) -> JointAssignment:
    """Return the first of the assignments that fit best, its text with the others that fit alike."""
    most = max(other.agreement for other in others)
    alike = {other.text: other for other in reversed(others) if other.agreement > most - ALIKE}
    first, *further = reversed(alike.values())
    texts = [other.text for other in further if other.opposite == first.opposite][:LISTED]
    told = f" (or, which fits as well, with {' or '.join(texts)})" if texts else ""
    return replace(first, text=first.text + told)


def _most_active_part(record: Record, length: int) -> Record:
    """Return the part in which the torques vary most."""
    starts = np.arange(0, record.n_samples - length, max(1, length // 4))
    scale = np.maximum(record.torque.std(axis=0), 1e-300)
    activity = [np.sum(record.torque[k : k + length].std(axis=0) / scale) for k in starts]
    first = int(starts[int(np.argmax(activity))])
    return record.part(first, first + length)


def _assignments(record: Record, robot: Robot) -> Iterator[JointAssignment]:
    """Yield torques and positions with other signs and orders, both alike or one of them."""
    M, names = robot.n_motors, robot.joint_names
    as_is = torque_balance(record, robot)
    for k in range(M):
        sign = np.ones(M)
        sign[k] = -1.0
        agreement = None if as_is is None else own_score(replace(as_is, given=sign * as_is.given), M)
        if agreement is not None:
            yield JointAssignment(f"the torque of {names[k]} inverted", agreement, opposite=True)
        yield from _both(record, robot, np.arange(M), sign, f"of {names[k]} inverted")
    for i, j in combinations(range(M), 2):
        order = np.arange(M)
        order[[i, j]] = order[[j, i]]
        yield from _both(record, robot, order, np.ones(M), f"of {names[i]} and {names[j]} exchanged")


def _axes_inverted(record: Record, robot: Robot) -> Iterator[JointAssignment]:
    """Invert torque and position of one joint after the other, each time that of the joint that improves most.

    Axes of other models of the same robot count the other way at several joints.
    """
    M, sign, reached = robot.n_motors, np.ones(robot.n_motors), -np.inf
    while np.any(sign > 0):
        trials = []
        for k in np.flatnonzero(sign > 0):
            other = np.where(np.arange(M) == k, -1.0, sign)
            changed = replace(record, position=other * record.position, torque=other * record.torque)
            balance = torque_balance(changed, robot)
            agreement = None if balance is None else own_score(balance, M)
            if agreement is not None:
                trials.append((agreement, int(k)))
        if not trials or max(trials)[0] <= reached + LEAST:
            return
        reached, best = max(trials)
        sign[best] = -1.0
        names = ", ".join(name for name, one in zip(robot.joint_names, sign, strict=True) if one < 0)
        yield JointAssignment(f"torque and position of {names} inverted", reached, opposite=False)


def _zeros_elsewhere(record: Record, robot: Robot) -> Iterator[JointAssignment]:
    """Turn the zero of one joint after the other by right angles, each time that of the joint that improves most.

    A model by Denavit and Hartenberg, the controller of the maker and a URDF count from different poses.
    """
    turns, reached = np.zeros(robot.n_motors), -np.inf
    rotary = [k for k, motor in enumerate(robot.motors) if motor.position_unit == "rad"]
    while True:
        trials = []
        for k in rotary:
            for angle in RIGHT_ANGLES if turns[k] == 0 else ():
                other = np.where(np.arange(robot.n_motors) == k, angle, turns)
                balance = torque_balance(replace(record, position=record.position + np.radians(other)), robot)
                agreement = None if balance is None else own_score(balance, robot.n_motors)
                if agreement is not None:
                    trials.append((agreement, k, angle))
        if not trials or max(trials)[0] <= reached + LEAST:
            return
        reached, best, angle = max(trials)
        turns[best] = angle
        text = ", ".join(f"{angle:+g} deg at {robot.joint_names[k]}" for k, angle in enumerate(turns) if angle)
        changed_zero = f"the zero of the positions elsewhere, {text} added"
        yield JointAssignment(changed_zero, reached, opposite=False, zeros=True)


def _weightless(record: Record, robot: Robot) -> Iterator[JointAssignment]:
    """Leave gravity out: some controllers compensate weights beside the torques that they state."""
    if not any(robot.spec.gravity.value):
        return
    balance = torque_balance(record, robot.with_values(WEIGHTLESS))
    agreement = None if balance is None else own_score(balance, robot.n_motors)
    if agreement is not None:
        text = "'gravity: [0, 0, 0]' in the robot file, as where the controller adds the weights to these torques"
        yield JointAssignment(text, agreement, opposite=False)


def _both(record: Record, robot: Robot, order: np.ndarray, sign: FloatArray, change: str) -> Iterator[JointAssignment]:
    """Change the positions, with or without the torques."""
    M = robot.n_motors
    changed = replace(record, position=sign * record.position[:, order], torque=sign * record.torque[:, order])
    balance = torque_balance(changed, robot)
    if balance is None:
        return
    kept = replace(balance, given=(sign * balance.given)[:, np.argsort(order)])
    for compared, signals in ((balance, "torque and position"), (kept, "the position")):
        agreement = own_score(compared, M)
        if agreement is not None:
            opposite = compared is kept and bool(np.any(sign < 0))
            exchanged = tuple(np.flatnonzero(order != np.arange(M)).tolist())
            yield JointAssignment(f"{signals} {change}", agreement, opposite, exchanged=exchanged)
