"""Time laws: the path parameter as an exact piecewise polynomial of time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class TimeLaw:
    """Motion s(t) of the path parameter from rest to rest, a polynomial between knots.

    Piece i holds for knots[i] <= t < knots[i + 1] and is sum_k coefficients[i, k] (t - origins[i])^k. Before the first
    knot the law rests at its start, from the last knot on at its end. The unit [p] is that of the path parameter.

    Args:
        knots: Times at which pieces begin, and the end [s], strictly increasing from 0, shape (n_pieces + 1,).
        origins: Times about which the pieces are expanded [s], shape (n_pieces,); one end of the piece, so that the
            rests before and after are exact.
        coefficients: Ascending powers, shape (n_pieces, degree + 1).
        start: Value before the first knot [p].
        end: Value from the last knot on [p].
        bounded_derivatives: Highest derivative without impulses (jumps are allowed): 3 for the
            quintic, 4 for bang-bang in the fourth derivative, 5 for the 9th degree.
        name: Name for messages, e.g. "quintic".
    """

    knots: FloatArray
    origins: FloatArray
    coefficients: FloatArray
    start: float
    end: float
    bounded_derivatives: int
    name: str

    @property
    def duration(self) -> float:
        """Time from the first to the last knot [s]."""
        return float(self.knots[-1])

    @property
    def rest_before(self) -> float:
        """Time for which the law rests at its start [s]; the whole duration if it never moves."""
        moving = np.flatnonzero(np.any(self.coefficients[:, 1:] != 0.0, axis=1))
        return float(self.knots[moving[0]]) if moving.size else self.duration

    def evaluate(self, t: FloatArray, derivatives: int = 4) -> FloatArray:
        """Return the path parameter and its time derivatives, without a check that they are bounded.

        Args:
            t: Times [s], any order, shape (n,). At a knot the values to its right are given.
            derivatives: Highest derivative.

        Returns:
            s [p], ds/dt [p/s], ..., shape (derivatives + 1, n).
        """
        t = np.asarray(t, dtype=float)
        result = np.zeros((derivatives + 1, t.size))
        result[0] = np.where(t < self.knots[0], self.start, self.end)
        moving = np.flatnonzero((t >= self.knots[0]) & (t < self.knots[-1]))
        piece = np.searchsorted(self.knots, t[moving], side="right") - 1
        local = t[moving] - self.origins[piece]
        coefficients = self.coefficients
        for order in range(min(derivatives, coefficients.shape[1] - 1) + 1):
            value = np.zeros(moving.size)
            for k in range(coefficients.shape[1] - 1, -1, -1):
                value = value * local + coefficients[piece, k]
            result[order, moving] = value
            coefficients = coefficients[:, 1:] * np.arange(1, coefficients.shape[1])
        return result

    def held(self, before: float = 0.0, after: float = 0.0) -> TimeLaw:
        """Return the law with rests before and after it.

        Args:
            before: Rest at the start [s].
            after: Rest at the end [s].

        Returns:
            The longer law.

        Raises:
            InputError: A time is negative or not finite.
        """
        rests = {"before": (before, self.start), "after": (after, self.end)}
        for name, (time, _) in rests.items():
            if not (np.isfinite(time) and time >= 0.0):
                raise InputError(f"the hold {name} the move is {time:g} s, allowed is 0 or a finite time; correct it")
        pieces = [rest(*rests["before"], self.bounded_derivatives)] if before > 0.0 else []
        pieces.append(self)
        if after > 0.0:
            pieces.append(rest(*rests["after"], self.bounded_derivatives))
        return concatenated(pieces)

    def mirrored(self) -> TimeLaw:
        """Return the law reversed in time."""
        duration = self.duration
        signs = (-1.0) ** np.arange(self.coefficients.shape[1])
        return replace(
            self,
            knots=(duration - self.knots)[::-1].copy(),
            origins=(duration - self.origins)[::-1].copy(),
            coefficients=(self.coefficients * signs)[::-1].copy(),
            start=self.end,
            end=self.start,
        )


def concatenated(laws: Sequence[TimeLaw]) -> TimeLaw:
    """Concatenate laws in time, each beginning where the previous one ends.

    Args:
        laws: At least one law.

    Returns:
        One law; its derivatives are bounded up to the lowest order of all.

    Raises:
        InputError: A law begins elsewhere than the previous one ends.
    """
    knots, origins, rows, shift = [np.zeros(1)], [], [], 0.0
    degree = max(law.coefficients.shape[1] for law in laws)
    for law, before in zip(laws, (None, *laws[:-1]), strict=True):
        if before is not None and abs(law.start - before.end) > 1e-9 * max(1.0, abs(before.end)):
            raise InputError(
                f"a time law begins at {law.start:.9g} where the previous one ends at {before.end:.9g}, allowed is the "
                "same path parameter; join moves of different paths in a trajectory instead"
            )
        knots.append(law.knots[1:] + shift)
        origins.append(law.origins + shift)
        rows.append(np.pad(law.coefficients, ((0, 0), (0, degree - law.coefficients.shape[1]))))
        shift += law.duration
    return TimeLaw(
        knots=np.concatenate(knots),
        origins=np.concatenate(origins),
        coefficients=np.vstack(rows),
        start=laws[0].start,
        end=laws[-1].end,
        bounded_derivatives=min(law.bounded_derivatives for law in laws),
        name=next((law.name for law in laws if law.name != "rest"), "rest"),
    )


def rest(duration: float, value: float = 0.0, bounded_derivatives: int = 5) -> TimeLaw:
    """Return the law that rests at a value.

    Args:
        duration: How long [s].
        value: The value [p].
        bounded_derivatives: Value of the attribute; all derivatives are zero.

    Returns:
        The law.
    """
    return TimeLaw(
        knots=np.array([0.0, duration]),
        origins=np.zeros(1),
        coefficients=np.array([[value]]),
        start=value,
        end=value,
        bounded_derivatives=bounded_derivatives,
        name="rest",
    )


def positive(value: float, name: str, unit: str) -> float:
    """Return a number that must be above zero.

    Args:
        value: The number.
        name: Its name in the message, e.g. "speed limit".
        unit: Its unit in the message.

    Raises:
        InputError: Zero, negative, infinite or not a number.
    """
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(f"the {name} is {value:g} {unit}, allowed is a finite number above 0; correct the {name}")
    return float(value)
