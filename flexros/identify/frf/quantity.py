"""Position, velocity, acceleration: the possible outputs of the frequency response of a motor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from flexros.errors import unknown_name

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray

Quantity = Literal["position", "velocity", "acceleration"]
"""Output quantity of a frequency response."""

QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
"""In the order of derivatives: position is the derivative of order 0."""

_PER_TIME = ("", "/s", "/s²")


def derivative_order(quantity: str) -> int:
    """Return the number of differentiations of position: 0 for position, 1 for velocity, 2 for acceleration.

    Args:
        quantity: Name of the quantity.

    Raises:
        InputError: The name is not known.
    """
    if quantity not in QUANTITIES:
        raise unknown_name("quantity of a frequency response", quantity, QUANTITIES)
    return QUANTITIES.index(quantity)


def differentiation(frequency: FloatArray, order: int) -> ComplexArray:
    """Return (j w)^order, which converts one quantity to another exactly.

    Args:
        frequency: Frequencies [Hz], shape (F,).
        order: Number of differentiations, negative for integrations.

    Returns:
        Factor [s^-order], shape (F,).
    """
    factor: ComplexArray = (2j * np.pi * np.asarray(frequency, dtype=float)) ** order
    return factor


def unit_of_quantity(coordinate_unit: str, quantity: str) -> str:
    """Return the unit of a quantity, e.g. "rad/s²" for the acceleration of a coordinate in "rad".

    Args:
        coordinate_unit: Unit of the position, "rad" or "m".
        quantity: Name of the quantity.
    """
    return coordinate_unit + _PER_TIME[derivative_order(quantity)]
