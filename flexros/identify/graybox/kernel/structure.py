"""What compiled frequency responses depend on besides numbers: sizes, non-zero places, parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from flexros.identify.graybox.kernel.elimination import Elimination, eliminate
from flexros.identify.graybox.sampled import ORDERS

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, ComplexArray, FloatArray
    from flexros.identify.graybox.frequency_model import FrequencyModel
    from flexros.robot.linear.positions import LinearisedPositions

Vector: TypeAlias = "tuple[tuple[int, float], ...]"
"""A rank-one vector as pairs (place, coefficient)."""
NEGLIGIBLE = 1e-14
"""Element beside the geometric mean of its diagonal elements that counts as zero."""
LANES = 8
"""Frequencies side by side."""


@dataclass(frozen=True)
class KernelStructure:
    """Structure of the code; equal structures share it.

    Attributes:
        n: Number of coordinates.
        places: Place of each motor among the coordinates, length M.
        entries: Places (row >= column) of A that are not zero in some position.
        damped: Those of them where D is not zero.
        vectors: Distinct rank-one vectors as pairs (place, coefficient), length J.
        parameters: Number of the vector and power of jw of each parameter, length P; slope g counts as vector J + g
            with power 0.
        n_slopes: Number of parameters that are no rank-one terms, G.
        touched: Coordinates that slopes reach.
    """

    n: int
    places: tuple[int, ...]
    entries: tuple[tuple[int, int], ...]
    damped: tuple[tuple[int, int], ...]
    vectors: tuple[Vector, ...]
    parameters: tuple[tuple[int, int], ...]
    n_slopes: int
    touched: tuple[int, ...]

    @cached_property
    def elimination(self) -> Elimination:
        """Order of elimination and fill-in."""
        return eliminate(self.n, self.entries, self.places)

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Elements (m, n) of the symmetric response with m <= n, in the order of all packed arrays."""
        return motor_pairs(len(self.places))

    @cached_property
    def sloped(self) -> range:
        """Turns of elimination between the first and the last coordinate that slopes reach."""
        turns = [turn for turn, place in enumerate(self.elimination.order) if place in self.touched]
        return range(turns[0], turns[-1] + 1) if turns else range(0)

    @property
    def matrix_numbers(self) -> int:
        """Numbers per position in packed matrices: K, M, D of entries, then of slopes."""
        return 3 * (len(self.entries) + self.n_slopes * len(self.sloped) ** 2)

    @property
    def factor_numbers(self) -> int:
        """Complex numbers per frequency that derivatives are made of: v of each vector, then products of slopes."""
        return len(self.vectors) * len(self.places) + self.n_slopes * len(self.pairs)

    @property
    def hold_numbers(self) -> int:
        """Numbers per frequency in packed holds: w, gain and aliases."""
        return 3 + 2 * len(ORDERS)


def motor_pairs(n_motors: int) -> tuple[tuple[int, int], ...]:
    """List the elements (m, n) with m <= n of a symmetric matrix, row by row."""
    return tuple((m, n) for m in range(n_motors) for n in range(m, n_motors))


def kernel_structure(positions: LinearisedPositions) -> KernelStructure:
    """Find the structure of linearised positions.

    Args:
        positions: Linear models.

    Returns:
        The structure, with every place that a parameter can make non-zero.
    """
    slopes = (positions.mass_slopes, positions.damping_slopes, positions.stiffness_slopes)
    sloped = [_places(slope.reshape(-1, *slope.shape[2:])) for slope in slopes]
    touched = np.einsum("pi,pj->ij", np.abs(positions.vectors), np.abs(positions.vectors)) != 0
    damped = touched | sloped[1] | _places(positions.damping)
    filled = damped | sloped[0] | sloped[2] | _places(positions.mass) | _places(positions.stiffness)
    lower = [(i, j) for i in range(len(filled)) for j in range(i + 1)]
    vectors, parameters = _vectors(positions)
    return KernelStructure(
        n=len(filled),
        places=tuple(int(place) for place in positions.motor_rows),
        entries=tuple(place for place in lower if filled[place] or place[0] == place[1]),
        damped=tuple(place for place in lower if damped[place]),
        vectors=vectors,
        parameters=parameters,
        n_slopes=len(positions.sloped),
        touched=tuple(int(place) for place in np.flatnonzero(np.any(sloped, axis=(0, 1)))),
    )


def _places(matrices: FloatArray) -> BoolArray:
    """Places that are more than rounding in some matrix: rounding must not decide what is compiled, shape (n, n)."""
    diagonal = np.sqrt(np.abs(np.einsum("qii->qi", matrices)))
    filled: BoolArray = np.any(np.abs(matrices) > NEGLIGIBLE * diagonal[:, :, None] * diagonal[:, None, :], axis=0)
    return filled


def _vectors(positions: LinearisedPositions) -> tuple[tuple[Vector, ...], tuple[tuple[int, int], ...]]:
    """Distinct rank-one vectors, and number and power of each parameter."""
    numbers: dict[Vector, int] = {}
    keys = [tuple((int(i), float(vector[i])) for i in np.flatnonzero(vector)) for vector in positions.vectors]
    for key in keys:
        if key:
            numbers.setdefault(key, len(numbers))
    slopes = {int(place): len(numbers) + slope for slope, place in enumerate(positions.sloped)}
    parameters = tuple(
        (slopes[place], 0) if place in slopes else (numbers[key], int(power))
        for place, (key, power) in enumerate(zip(keys, positions.powers, strict=True))
    )
    return tuple(numbers), parameters


def packed_matrices(structure: KernelStructure, positions: LinearisedPositions, theta: FloatArray) -> FloatArray:
    """K, M, D of every position: of the entries, then of the slopes in the order of elimination.

    Args:
        structure: Structure of the code.
        positions: Linear models.
        theta: Values of the parameters (SI), shape (P,).

    Returns:
        Numbers, shape (Q, matrix_numbers).
    """
    n_positions = len(positions.mass)
    rows, columns = np.array(structure.entries).T
    mass, damping, stiffness = (matrix[:, rows, columns] for matrix in positions.matrices(theta))
    packed = np.empty((n_positions, structure.matrix_numbers))
    packed[:, : 3 * len(rows)] = np.stack([stiffness, mass, damping], axis=-1).reshape(n_positions, -1)
    if structure.n_slopes:
        order = np.array(structure.elimination.order)[list(structure.sloped)]
        slopes = (positions.stiffness_slopes, positions.mass_slopes, positions.damping_slopes)
        picked = np.stack([slope[:, :, order[:, None], order] for slope in slopes], axis=-1)
        packed[:, 3 * len(rows) :] = picked.reshape(n_positions, -1)
    return packed


def packed_hold(model: FrequencyModel) -> FloatArray:
    """Angular frequency, gain and aliases in blocks of LANES frequencies; the last frequency fills the last block.

    Args:
        model: Frequency model.

    Returns:
        Numbers per block, shape (Q, blocks, 3 + 2 orders, LANES).
    """
    hold = model.hold
    aliases = np.stack([hold.aliases.real, hold.aliases.imag], axis=-1)
    numbers = [hold.omega, hold.gain.real, hold.gain.imag, *np.moveaxis(aliases.reshape(*hold.omega.shape, -1), -1, 0)]
    return in_blocks(np.stack(numbers, axis=-1))


def in_blocks(numbers: FloatArray, fill: float | None = None) -> FloatArray:
    """Bring numbers per frequency into blocks of frequencies.

    Args:
        numbers: Numbers, shape (Q, F, k).
        fill: What fills the last block; default: the numbers of the last frequency.

    Returns:
        The numbers, shape (Q, blocks, k, LANES).
    """
    missing = -numbers.shape[1] % LANES
    tail = np.repeat(numbers[:, -1:], missing, axis=1)
    padded = np.concatenate([numbers, tail if fill is None else np.full_like(tail, fill)], axis=1)
    blocks = padded.reshape(len(numbers), -1, LANES, numbers.shape[-1])
    return np.ascontiguousarray(blocks.swapaxes(2, 3))


def out_of_blocks(blocks: FloatArray, n_frequencies: int) -> ComplexArray:
    """Undo `in_blocks` for complex numbers whose parts stand in turn.

    Args:
        blocks: Parts, shape (Q, blocks, 2 k, LANES).
        n_frequencies: F.

    Returns:
        Numbers, shape (Q, F, k).
    """
    parts = blocks.swapaxes(2, 3).reshape(len(blocks), -1, blocks.shape[2])[:, :n_frequencies]
    return np.ascontiguousarray(parts).view(np.complex128)
