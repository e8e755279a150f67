"""Rows of a foreign log that can be used: a row without a value or a time of its own is lost, not the whole log."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, FloatArray

FEWEST = 2
"""Smallest number of rows of a log."""

MOST_LOST = 0.3
"""Largest share of rows that may lack a value or a time (chosen, as for the samples of a record)."""

LARGEST = 1e9
"""Largest value of any quantity [SI unit] (chosen); beyond it numbers are damaged."""


def usable_times(time: FloatArray, clock: str) -> tuple[BoolArray, tuple[str, ...]]:
    """Choose the rows whose times increase: of rows with the same time the first one, and none without a time.

    Args:
        time: Times [s], shape (n,).
        clock: File and time column, for messages.

    Returns:
        Rows that are used, shape (n,), and what was left out, one sentence each.

    Raises:
        InputError: Fewer than two rows, a large part without a time of its own, or a time goes back.
    """
    n, notes = len(time), []
    used = np.isfinite(time)
    if n < FEWEST:
        raise InputError(f"{clock} has {n} rows, but at least {FEWEST} are needed; give a longer log")
    if n_lost := int(np.count_nonzero(~used)):
        where = f"in {n_lost} of {n} rows (first: row {int(np.argmin(used)) + 1})"
        if n_lost > MOST_LOST * n:
            raise InputError(
                f"{clock} has no finite time {where}, allowed is a share of {MOST_LOST:g}; remove these rows"
            )
        notes.append(f"{clock} has no finite time {where}; these rows are left out")
    rows = np.flatnonzero(used)
    step = np.diff(time[rows])
    if np.any(step < 0):
        first = int(np.argmax(step < 0))
        raise InputError(
            f"{clock}, row {rows[first + 1] + 1}: the time goes back ({time[rows[first]]:.9g} s, then "
            f"{time[rows[first + 1]]:.9g} s; {np.count_nonzero(step < 0)} such rows), but must increase; sort the "
            "rows, or leave out those that are broken"
        )
    repeated = rows[1:][step == 0]
    if repeated.size:
        where = f"in {repeated.size} of {n} rows (first: row {repeated[0] + 1})"
        if repeated.size > MOST_LOST * n:
            raise InputError(
                f"{clock} repeats the time before {where}, allowed is a share of {MOST_LOST:g}: it is too coarse for "
                "these rows; give their rate (time: {rate: HZ}) or finer times"
            )
        notes.append(f"{clock} repeats the time before {where}; the first row of each time is kept")
        used[repeated] = False
    return used, tuple(notes)


@dataclass
class LostValues:
    """Values of the columns that are not finite, told once for columns that lack the same rows.

    Attributes:
        columns: Names of the columns by file and by the bytes of the marks of their lost rows.
    """

    columns: dict[tuple[str, bytes], list[str]] = field(default_factory=lambda: defaultdict(list))

    def marked(self, values: FloatArray, used: BoolArray, file: str, column: str, quantity: str) -> FloatArray:
        """Return the values, NaN where they are not finite.

        Args:
            values: Values [SI unit], shape (n,).
            used: Rows that are used, shape (n,).
            file: The file, for messages.
            column: Name of the column or columns.
            quantity: What it holds, e.g. "position of motor_1".

        Raises:
            InputError: A large part is not finite.
        """
        lost = used & ~np.isfinite(values)
        n, n_used = int(np.count_nonzero(lost)), int(np.count_nonzero(used))
        title = f"{file}, column '{column}' ({quantity})"
        if n == n_used:
            raise InputError(f"{title} has no finite value in {n_used} rows; map a column with data, or leave it out")
        if n > MOST_LOST * n_used:
            raise InputError(
                f"{title} is not finite in {n} of {n_used} rows (first: row {int(np.argmax(lost)) + 1}), allowed is a "
                f"share of {MOST_LOST:g}; a quantity of a lower rate needs a file of its own, with its own times"
            )
        if n and column not in (listed := self.columns[file, lost.tobytes()]):
            listed.append(column)
        return np.where(np.isfinite(values), values, np.nan)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was lost, one sentence for each set of rows."""
        return tuple(
            f"{file}: {mark.count(1)} of {len(mark)} rows have no finite value of {', '.join(columns)} (first: row "
            f"{mark.index(1) + 1}); these samples are lost"
            for (file, mark), columns in self.columns.items()
        )


def check_size(values: FloatArray, given: FloatArray, column: str) -> None:
    """Refuse values beyond any measurement.

    Args:
        values: Values [SI unit], shape (n,).
        given: The same as in the file, shape (n,).
        column: File and column, for the message.

    Raises:
        InputError: A value is beyond `LARGEST`.
    """
    bad = np.flatnonzero(np.abs(values) > LARGEST)
    if bad.size:
        raise InputError(
            f"{column}, row {bad[0] + 1}: {given[bad[0]]:.4g} is {values[bad[0]]:.4g} in SI units, but at most "
            f"{LARGEST:.0e} is a measurement ({bad.size} such rows); remove damaged rows, or correct the scale"
        )
