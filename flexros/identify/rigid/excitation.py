"""Excitation of a motion: the base parameters that it excites, and the reasons for the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.rigid.base_parameters import independent_columns

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.identify.rigid.base_parameters import BaseParameters

LARGEST_CONDITION = 100.0
"""Largest condition number of a sufficiently exciting motion (M. Gautier and W. Khalil, 1992)."""

_LEAST_SHARE = 0.02
"""Smallest share of a column unexplained by the others for its parameter to be estimated (chosen)."""

_ALIKE = 0.1
"""Smallest coefficient of a column in explaining another for its parameter to be named (chosen)."""


@dataclass(frozen=True)
class NotExcited:
    """A base parameter that the motion does not excite on its own.

    Attributes:
        name: Its name.
        reason: The reason as text.
    """

    name: str
    reason: str


@dataclass(frozen=True)
class Excitation:
    """Base parameters that a motion excites.

    Attributes:
        shown: Indices of the base parameters that can be estimated.
        not_excited: The others.
    """

    shown: tuple[int, ...]
    not_excited: tuple[NotExcited, ...]


def judge_excitation(H: FloatArray, base: BaseParameters) -> Excitation:
    """Determine the base parameters that a motion excites; the others keep their nominal value in the regression.

    Args:
        H: Regressor of the base parameters, rows weighted, shape (n, M, r).
        base: The base parameters.
    """
    columns = H.reshape(-1, H.shape[2])
    shown = independent_columns(columns, _LEAST_SHARE)
    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, shown] / size[shown]
    missing = []
    for column in range(H.shape[2]):
        if column in shown:
            continue
        if size[column] <= 1e-12 * size.max():
            missing.append(NotExcited(base.names[column], "nothing in the motion depends on it"))
            continue
        share = np.linalg.lstsq(scaled, columns[:, column] / size[column], rcond=None)[0]
        order = [k for k in np.argsort(-np.abs(share)) if abs(share[k]) > _ALIKE][:3]
        names = ", ".join(base.names[shown[k]] for k in order)
        missing.append(NotExcited(base.names[column], f"in this motion it acts like {names}"))
    return Excitation(tuple(shown), tuple(missing))
