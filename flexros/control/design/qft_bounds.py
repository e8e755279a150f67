"""Bounds of quantitative feedback theory: what every loop of a template has to keep, and by how much it does not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, eq=False)
class Specifications:
    """What every loop of a template has to keep, at F frequencies.

    Attributes:
        sensitivity: Largest |1 / (1 + P K)| [1].
        complementary: Largest |P K / (1 + P K)| [1].
        compliance: Largest |P / (1 + P K)|, motor position per disturbance torque [rad/Nm or m/N], shape (F,).
    """

    sensitivity: float
    complementary: float
    compliance: FloatArray


def excess(template: ComplexArray, controller: ComplexArray, specifications: Specifications) -> FloatArray:
    """Return by how much the worst specification is exceeded at every frequency.

    Args:
        template: Responses of all plants, shape (Q, F).
        controller: Response of the controller, shape (F,).
        specifications: The specifications.

    Returns:
        Largest logarithm of value over limit, not above 0 where all are kept, shape (F,).
    """
    distance = np.abs(1.0 + template * controller)
    values = np.stack(
        [
            1.0 / distance / specifications.sensitivity,
            np.abs(template * controller) / distance / specifications.complementary,
            np.abs(template) / distance / specifications.compliance,
        ]
    )
    return np.asarray(np.log(np.max(values, axis=(0, 1))))
