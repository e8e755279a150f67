"""Trajectory: successive moves along paths, each with its time law."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.path import MAX_DERIVATIVES, text
from flexros.trajectory.rest_path import Rest
from flexros.trajectory.time_law import rest

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.trajectory.path import AbstractPath
    from flexros.trajectory.time_law import TimeLaw

JOINTS = "joints"
"""Output label of trajectories in joint space."""


@dataclass(frozen=True, eq=False)
class Move:
    """One motion from rest to rest along a path.

    Args:
        path: The geometry.
        law: The time law; its value runs over [0, path.extent], forwards or backwards.
    """

    path: AbstractPath
    law: TimeLaw

    def __post_init__(self) -> None:
        extent = self.path.extent
        for value in (self.law.start, self.law.end):
            if not -1e-9 * extent <= value <= extent * (1.0 + 1e-9):
                raise InputError(
                    f"the time law ends at {value:.9g} {self.path.parameter_unit}, allowed is at most the path's "
                    f"extent {extent:.9g}; make the time law for the distance path.extent"
                )

    def evaluate(self, t: FloatArray, derivatives: int) -> FloatArray:
        """Return point and time derivatives by Faa di Bruno's formula, shape (derivatives + 1, n, n_out)."""
        s = self.law.evaluate(t, derivatives)
        p = self.path.derivatives(np.clip(s[0], 0.0, self.path.extent), derivatives)
        s1, s2, s3, s4 = (s[k][:, None] if k <= derivatives else None for k in range(1, 5))
        result = np.empty_like(p)
        result[0] = p[0]
        if s1 is not None:
            result[1] = p[1] * s1
        if s1 is not None and s2 is not None:
            result[2] = p[2] * s1**2 + p[1] * s2
        if s1 is not None and s2 is not None and s3 is not None:
            result[3] = p[3] * s1**3 + 3.0 * p[2] * s1 * s2 + p[1] * s3
        if s1 is not None and s2 is not None and s3 is not None and s4 is not None:
            result[4] = p[4] * s1**4 + 6.0 * p[3] * s1**2 * s2 + p[2] * (3.0 * s2**2 + 4.0 * s1 * s3) + p[1] * s4
        return result


@dataclass(frozen=True)
class PathPoint:
    """A point on a trajectory, for messages.

    Args:
        time: [s].
        move: Number of the move, from 1.
        parameter: Path parameter.
        parameter_unit: Its unit.
        percent: Fraction of the move's path [%]; 0 at rest.
        coordinates: Point, tool coordinates or joint positions.
    """

    time: float
    move: int
    parameter: float
    parameter_unit: str
    percent: float
    coordinates: tuple[float, ...]

    def __str__(self) -> str:
        unit = "" if self.parameter_unit == "1" else f" {self.parameter_unit}"
        return (
            f"t = {self.time:.4f} s, {self.percent:.1f} % of move {self.move} (path parameter "
            f"{self.parameter:.6g}{unit}), point {text(np.array(self.coordinates))}"
        )


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Position over time with up to four exact time derivatives; rests before 0 and from `duration` on.

    Args:
        moves: Moves in order, each beginning where the previous one ends, shape (n_moves,).
        output: What the coordinates are: name of a robot output, or "joints".

    Raises:
        InputError: No move, or a move that begins elsewhere than the previous one ends.
    """

    moves: tuple[Move, ...]
    output: str

    def __post_init__(self) -> None:
        if not self.moves:
            raise InputError("the trajectory has no move, allowed is one or more; add a move")
        for number, (move, following) in enumerate(zip(self.moves[:-1], self.moves[1:], strict=True), start=1):
            end, start = move.path.point_at(move.law.end), following.path.point_at(following.law.start)
            if end.shape != start.shape or not np.allclose(end, start, rtol=1e-9, atol=1e-9):
                raise InputError(
                    f"move {number} of the trajectory ends at {text(end)} and move {number + 1} begins at "
                    f"{text(start)}, allowed is a move that begins where the previous one ends; return to the start or "
                    "add a move between"
                )

    @classmethod
    def at_rest(cls, where: FloatArray, output: str = JOINTS) -> Trajectory:
        """Return the trajectory that rests at a point.

        Args:
            where: The point, shape (n_out,).
            output: What the coordinates are: name of a robot output, or "joints".

        Returns:
            A rest of 1 s (chosen), which continues for all times.

        Raises:
            InputError: Not a vector of finite numbers.
        """
        return cls((Move(Rest(where), rest(1.0)),), output)

    @property
    def joints(self) -> bool:
        """Whether the coordinates are joint positions."""
        return self.output == JOINTS

    @property
    def n_out(self) -> int:
        """Number of coordinates."""
        return self.moves[0].path.n_out

    @cached_property
    def begins(self) -> FloatArray:
        """Times at which the moves begin, and the end of the last [s], shape (n_moves + 1,)."""
        return np.concatenate(([0.0], np.cumsum([move.law.duration for move in self.moves])))

    @property
    def duration(self) -> float:
        """Time from the start to the end of the last hold [s]."""
        return float(self.begins[-1])

    @property
    def rest_before(self) -> float:
        """Time for which the trajectory rests at its start [s]; the whole duration if it never moves."""
        resting = 0.0
        for move in self.moves:
            resting += move.law.rest_before
            if move.law.rest_before < move.law.duration:
                break
        return resting

    def delayed(self, time: float) -> Trajectory:
        """Return the trajectory with a longer rest at its start.

        Args:
            time: Additional rest [s].

        Raises:
            InputError: The time is negative or not finite.
        """
        first = self.moves[0]
        return replace(self, moves=(Move(first.path, first.law.held(before=time)), *self.moves[1:]))

    @property
    def bounded_derivatives(self) -> int:
        """Highest derivative without impulses: 3 with a quintic time law, at least 4 otherwise."""
        return min(move.law.bounded_derivatives for move in self.moves)

    @property
    def start(self) -> FloatArray:
        """First point, shape (n_out,)."""
        return self.moves[0].path.point_at(self.moves[0].law.start)

    @property
    def end(self) -> FloatArray:
        """Last point, held for all later times, shape (n_out,)."""
        return self.moves[-1].path.point_at(self.moves[-1].law.end)

    def evaluate(self, t: FloatArray, derivatives: int = MAX_DERIVATIVES) -> FloatArray:
        """Return the position and its time derivatives.

        Args:
            t: Times [s], any order, shape (n,); before 0 the start and from `duration` on the end is held.
            derivatives: Highest derivative, 0 to 4.

        Returns:
            Position, speed, acceleration, jerk, snap, shape (derivatives + 1, n, n_out). Where the highest jumps, the
            value to the right is given.

        Raises:
            InputError: More derivatives than the trajectory has.
        """
        if not 0 <= derivatives <= MAX_DERIVATIVES:
            raise InputError(f"{derivatives} derivatives were requested, allowed are 0 to 4")
        self._require(derivatives)
        t = np.atleast_1d(np.asarray(t, dtype=float))
        number = self._move_at(t)
        result = np.empty((derivatives + 1, t.size, self.n_out))
        for i in np.unique(number):
            chosen = number == i
            result[:, chosen] = self.moves[i].evaluate(t[chosen] - self.begins[i], derivatives)
        return result

    def sample_times(self, per_move: int) -> FloatArray:
        """Return times for a check of the trajectory: equally many on every move, repeated moves once.

        Args:
            per_move: Number of times on every move, at least 2.

        Returns:
            Times [s], increasing, shape (n,).
        """
        seen, times = set(), []
        for begin, move in zip(self.begins, self.moves, strict=False):
            if (id(move.path), id(move.law)) not in seen:
                seen.add((id(move.path), id(move.law)))
                times.append(begin + np.linspace(0.0, move.law.duration, max(2, per_move)))
        return np.unique(np.concatenate(times))

    def place(self, t: float) -> PathPoint:
        """Return the point of the trajectory at a time [s]."""
        times = np.array([t], dtype=float)
        i = int(self._move_at(times)[0])
        path, law = self.moves[i].path, self.moves[i].law
        s = float(law.evaluate(times - self.begins[i], 0)[0, 0])
        distance = abs(law.end - law.start)
        share = abs(s - law.start) / distance if distance > 0.0 else 0.0
        return PathPoint(float(t), i + 1, s, path.parameter_unit, 100.0 * share, tuple(path.point_at(s).tolist()))

    def _move_at(self, t: FloatArray) -> FloatArray:
        """Return the index of the move at every time, shape (n,)."""
        return np.clip(np.searchsorted(self.begins, t, side="right") - 1, 0, len(self.moves) - 1)

    def _require(self, derivatives: int) -> None:
        if derivatives > self.bounded_derivatives:
            names = sorted({move.law.name for move in self.moves if move.law.bounded_derivatives < derivatives})
            raise InputError(
                f"derivative {derivatives} of a trajectory with the time law {', '.join(names)} was requested, which "
                f"has only {self.bounded_derivatives} (its jerk jumps at both ends, the next derivative has impulses "
                "there); choose ninth_degree or bang_bang_snap, or a feedforward that needs fewer derivatives"
            )
