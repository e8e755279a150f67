"""Candidate positions of an experiment: spread evenly over ranges of the gears, as far as the physics allows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.stats import qmc

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike

    from flexros.arrays import FloatArray, IntArray
    from flexros.robot import Robot

ROTARY_REACH = 1.0
"""Default range of a rotary axis either side of the home pose [rad] (chosen; robot files state no limits)."""
LINEAR_REACH = 0.2
"""Default range of a linear axis either side of the home pose [m] (chosen)."""
TORQUE_SHARE = 0.6
"""Largest share of the torque limit that gravity may take; the rest is for the excitation (chosen)."""
_MOST_REFUSED = 50
"""Give up when fewer than one in this many positions can be held (chosen)."""


@dataclass(frozen=True, eq=False)
class CandidatePositions:
    """Positions in which an experiment could be made.

    Attributes:
        gears: Gear coordinates on the arm side [rad or m], shape (Q, M).
        motor_positions: Motor positions that hold them under gravity [rad or m], shape (Q, M).
        refused: Number of positions that were drawn but cannot be used, by reason.
    """

    gears: FloatArray
    motor_positions: FloatArray
    refused: Mapping[str, int]

    def only(self, kept: IntArray, reason: str) -> CandidatePositions:
        """Leave positions out.

        Args:
            kept: Numbers of the positions that stay, shape (Q',).
            reason: Why the others go, for `refused`.
        """
        gone = len(self.gears) - len(kept)
        refused = {**self.refused, reason: gone} if gone else self.refused
        return CandidatePositions(self.gears[kept], self.motor_positions[kept], refused)


def default_ranges(robot: Robot) -> FloatArray:
    """Return a range of each gear about the home pose [rad or m], shape (M, 2); chosen, as robots state none."""
    home = robot.home[list(robot.gear_rows)]
    reach = np.array([ROTARY_REACH if motor.rotary else LINEAR_REACH for motor in robot.motors])
    return np.stack([home - reach, home + reach], axis=1)


def candidate_positions(
    robot: Robot,
    number: int = 4000,
    ranges: ArrayLike | None = None,
    seed: int = 1,
    progress: Callable[[int], None] | None = None,
) -> CandidatePositions:
    """Spread positions over the ranges of the gears by a scrambled Halton sequence.

    A position is refused where the springs find no balance with gravity, where the balance is not stable with the
    motors held, or where gravity takes more than `TORQUE_SHARE` of a motor's torque limit.

    Args:
        robot: The robot.
        number: Number of positions that are wanted.
        ranges: Smallest and largest coordinate of each gear [rad or m], shape (M, 2); default: `default_ranges`.
        seed: Seed of the scrambling.
        progress: Called with the number of positions so far.

    Returns:
        The positions.

    Raises:
        InputError: The ranges are not M pairs in order, or hardly any position within them can be held.
    """
    if number < 1:
        raise InputError(f"{number} candidate positions were requested, but at least one is needed")
    limits = _checked(robot, default_ranges(robot) if ranges is None else np.asarray(ranges, dtype=float))
    sequence = qmc.Halton(d=robot.n_motors, seed=seed)
    judge = _Judge(robot)
    gears: list[FloatArray] = []
    motors: list[FloatArray] = []
    refused: dict[str, int] = {}
    for drawn in range(_MOST_REFUSED * number + _MOST_REFUSED):
        gear = limits[:, 0] + sequence.random(1)[0] * (limits[:, 1] - limits[:, 0])
        motor, reason = judge.judge(gear)
        if motor is None:
            refused[reason] = refused.get(reason, 0) + 1
        else:
            gears.append(gear)
            motors.append(motor)
        if progress is not None:
            progress(len(gears))
        if len(gears) == number or (drawn >= _MOST_REFUSED and len(gears) * _MOST_REFUSED < drawn):
            break
    if len(gears) < number:
        raise InputError(_too_few(robot, limits, len(gears), refused))
    return CandidatePositions(np.array(gears), np.array(motors), refused)


class _Judge:
    """Check that a robot can be held in a position."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        model, n = robot.model, robot.n_coordinates
        q, p = ca.SX.sym("q", n), model.parameter_values
        force = model.force(q, np.zeros(n), np.zeros(robot.n_motors), np.zeros(6), p)
        free = [row for row in range(n) if row not in robot.motor_rows]
        stiffness = -ca.jacobian(force[free], q)[:, free] if free else ca.SX(0, 0)
        self._stiffness = ca.Function("stiffness", [q], [ca.densify(stiffness)])
        self._encoder = model.encoder

    def judge(self, gears: FloatArray) -> tuple[FloatArray | None, str]:
        """Return the motor positions that hold gear coordinates, or None and the reason."""
        robot = self._robot
        try:
            state = robot.equilibrium(robot.arm_from_gears(gears))
        except InputError:
            return None, "the springs do not balance gravity"
        q = state[: robot.n_coordinates]
        stiffness = self._stiffness(q).full()
        if stiffness.size and np.min(np.linalg.eigvalsh(stiffness + stiffness.T)) <= 0.0:
            return None, "the rest is not stable"
        if np.any(np.abs(robot.holding_torque(state)) > TORQUE_SHARE * robot.torque_limits):
            return None, f"gravity takes more than {TORQUE_SHARE:.0%} of a torque limit"
        motor: FloatArray = self._encoder(q).full().ravel()
        return motor, ""


def _checked(robot: Robot, limits: FloatArray) -> FloatArray:
    if limits.shape != (robot.n_motors, 2) or not np.all(np.isfinite(limits)) or np.any(limits[:, 0] > limits[:, 1]):
        raise InputError(
            f"the ranges of the gears are {limits.tolist()}, but robot {robot.name} needs {robot.n_motors} pairs of "
            "smallest and largest coordinate [rad or m]; correct them"
        )
    return limits


def _too_few(robot: Robot, limits: FloatArray, held: int, refused: Mapping[str, int]) -> str:
    reasons = ", ".join(f"{reason}: {count}" for reason, count in sorted(refused.items()))
    return (
        f"robot {robot.name} can be held in only {held} of {held + sum(refused.values())} positions within the "
        f"ranges {np.round(limits, 4).tolist()} ({reasons}); give other ranges"
    )
