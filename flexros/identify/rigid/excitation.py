"""Whether a motion is rich enough for all base parameters, and which of them it does not show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.rigid.base_parameters import independent_columns

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.rigid.base_parameters import BaseParameters

LARGEST_CONDITION = 100.0
"""Condition number up to which a motion counts as rich enough (M. Gautier and W. Khalil, 1992)."""

_LEAST_SHARE = 0.02
"""Share of a column that the others must leave unexplained, else its parameter is not estimated (chosen)."""

_ALIKE = 0.1
"""Share that a column must have in explaining another to be named beside it (chosen)."""


@dataclass(frozen=True)
class NotExcited:
    """A base parameter that the motion does not show on its own.

    Attributes:
        name: Its name.
        reason: Why, in words.
    """

    name: str
    reason: str


@dataclass(frozen=True)
class Excitation:
    """What a motion shows.

    Attributes:
        shown: Places of the base parameters that can be estimated.
        not_excited: The others.
    """

    shown: tuple[int, ...]
    not_excited: tuple[NotExcited, ...]


def judge_excitation(H: FloatArray, base: BaseParameters) -> Excitation:
    """Find the base parameters that a motion shows.

    Args:
        H: Regressor of the base parameters, rows weighted, shape (n, M, r).
        base: The base parameters.

    Returns:
        The verdict. A parameter that is not shown keeps its nominal value in the regression.
    """
    columns = H.reshape(-1, H.shape[2])
    shown = independent_columns(columns, _LEAST_SHARE)
    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, shown] / size[shown]
    missing = []
    for place in range(H.shape[2]):
        if place in shown:
            continue
        if size[place] <= 1e-12 * size.max():
            missing.append(NotExcited(base.names[place], "nothing in the motion depends on it"))
            continue
        share = np.linalg.lstsq(scaled, columns[:, place] / size[place], rcond=None)[0]
        order = [k for k in np.argsort(-np.abs(share)) if abs(share[k]) > _ALIKE][:3]
        names = ", ".join(base.names[shown[k]] for k in order)
        missing.append(NotExcited(base.names[place], f"in this motion it acts like {names}"))
    return Excitation(tuple(shown), tuple(missing))
