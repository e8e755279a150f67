"""Torques of an imported log that may be known better than is assumed, as those of a simulator or a calibrated drive.

Within the assumed tolerance effects stay hidden, and what they do goes into the sizes of others. How well torques are
known nobody can tell from what an explanation leaves: that may be their error, or effects that are missing. So a search
on trial counts less than that as no gap. Where further effects explain most of what is left, in both logs, the torques
are that good.
"""

from __future__ import annotations

import math

MOST = 1.0
"""Mean squared error that an explanation leaves beyond noise, over that of the assumed tolerance, up to which torques
may be better [1]: within the tolerance."""

STILL = 0.5
"""The same after a search on trial: over the assumed tolerance where torques are better, and over that on trial where
they may be better still [1] (chosen)."""

STRICTER = 0.4
"""Tolerance on trial over what an explanation leaves [1] (chosen)."""

LEAST = 0.005
"""Smallest tolerance on trial, relative to the rms of a torque [1] (chosen)."""

MOST_BEGUN = 2.0
"""The same of the explanation with which a search on trial begins, in the fitted log, up to which there is hope [1]
(chosen): 0.02 to 0.9 where torques are those of a simulator. Another motion may show a delay or a ripple that is still
missing far more, and counts once the search has ended."""


def tolerance_on_trial(tolerance: float, left: float, *, again: bool = False) -> float | None:
    """Return a smaller tolerance of the torques for a search on trial.

    Args:
        tolerance: The one that counts now, relative to the rms of a torque [1].
        left: Mean squared error beyond noise that the explanation leaves, over that of this tolerance [1].
        again: Whether this tolerance was on trial itself.

    Returns:
        The tolerance [1]; None where torques are not much better than assumed.
    """
    if left > (STILL if again else MOST):
        return None
    tried = max(float(f"{STRICTER * math.sqrt(left) * tolerance:.1g}"), LEAST)
    return tried if tried < tolerance / 2 else None


def are_better(tolerance: float, tried: float, left: float, *, instead: bool = True) -> bool:
    """Return whether torques are known better than assumed, after a search on trial.

    An observer that follows a log more loosely shows more of it. On a linear drive whose torques are known very well,
    friction was no longer Coulomb friction there: curves, a ripple of any order and a limit of the force removed most
    of what was left, and still left 7 % of the force.

    Args:
        tolerance: The assumed one, relative to the rms of a torque [1].
        tried: The one on trial [1].
        left: Mean squared error beyond noise that the explanation leaves, over that of the one on trial [1].
        instead: Whether it would take the place of an explanation: where none was found, within the assumed tolerance
            is enough.
    """
    return left * tried**2 < (STILL if instead else MOST) * tolerance**2


def most_begun(tolerance: float, tried: float) -> float:
    """Return what the first explanation of a search on trial may leave, over the tolerance on trial [1].

    Args:
        tolerance: The assumed one, relative to the rms of a torque [1].
        tried: The one on trial [1].
    """
    return MOST_BEGUN * (tolerance / tried) ** 2
