"""Point-to-point moves: time until the tool stays in its band, stabilisation and overshoot (ISO 9283, clause 7.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.path_geometry import distances, step_lengths

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.analysis.cycles import Cycle

BAND = 0.3e-3
"""Half width of the band about the attained position [m] (Moberg 2007, section 5.5: an error band of 0.3 mm)."""

SHORTEST_REST = 0.05
"""Shortest rest of the commanded position that counts as a stop [s] (chosen)."""

ATTAINED = 0.2
"""Share of the rest at its end whose mean is the attained position [1] (chosen)."""

_MOVES = 1e-9
"""Commanded motion per sample above which the command moves [m]."""


@dataclass(frozen=True)
class Stop:
    """A stop after a move.

    Attributes:
        time: Time at which the command stops [s].
        positioning: Time from the begin of the commanded move until the tool stays within the band [s]; None where it
            is not in the band before the next move.
        settling: Time from the end of the commanded move until then [s], 0 where it is in the band before; or None.
        stabilisation: Time from the first entry into the band until the last [s]; or None.
        overshoot: Largest distance from the attained position after the first entry, 0 where the tool does not leave
            the band again [m]; or None.
    """

    time: float
    positioning: float | None
    settling: float | None
    stabilisation: float | None
    overshoot: float | None

    def as_dict(self) -> Mapping[str, float | None]:
        """Return the figures, with units in the keys."""
        return {
            "time_s": self.time,
            "positioning_time_s": self.positioning,
            "settling_time_s": self.settling,
            "stabilisation_time_s": self.stabilisation,
            "overshoot_mm": None if self.overshoot is None else 1e3 * self.overshoot,
        }


def stops(run: Cycle, band: float = BAND) -> tuple[Stop, ...]:
    """Evaluate every stop of a run.

    Args:
        run: Commanded and attained positions of the whole run, at even times.
        band: Half width of the band about the attained position [m].

    Returns:
        The stops after a move, in order; rests shorter than `SHORTEST_REST` are skipped.
    """
    moving = step_lengths(run.commanded) > _MOVES
    edges = np.flatnonzero(np.diff(np.concatenate([[False], moving, [False]])))
    begins, ends = edges[::2], edges[1::2]
    found = []
    begin = begins[0] if len(begins) else 0
    for k, end in enumerate(ends):
        following = begins[k + 1] if k + 1 < len(begins) else len(run.time) - 1
        if run.time[following] - run.time[end] < SHORTEST_REST:
            continue
        found.append(_stop(run, int(begin), int(end), int(following) + 1, band))
        begin = following
    return tuple(found)


def _stop(run: Cycle, begin: int, end: int, after: int, band: float) -> Stop:
    """Evaluate the stop of a move from sample `begin` to `end`, which lasts until before sample `after`."""
    last = max(1, round(ATTAINED * (after - end)))
    place = run.attained[after - last : after].mean(axis=0)
    distance = distances(run.attained[begin:after], np.broadcast_to(place, (after - begin, 3)))
    outside = np.flatnonzero(distance > band)
    time = float(run.time[end])
    if outside.size and outside[-1] + 1 >= len(distance) - last:
        return Stop(time, None, None, None, None)
    inside = begin + (int(outside[-1]) + 1 if outside.size else 0)
    left = np.flatnonzero(distance > distance[0] / 2) if distance[0] > band else outside
    away = int(left[-1]) + 1 if left.size else 0  # the tool is past the middle of its way
    if away == len(distance):  # the middle of a short way is in the band, and so is all that follows
        away = 0
    entry = away + int(np.argmax(distance[away:] <= band))
    overshoot = float(distance[entry:].max())
    return Stop(
        time,
        positioning=float(run.time[inside] - run.time[begin]),
        settling=max(0.0, float(run.time[inside] - time)),
        stabilisation=float(run.time[inside] - run.time[begin + entry]),
        overshoot=overshoot if overshoot > band else 0.0,
    )
