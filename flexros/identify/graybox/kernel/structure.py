"""Structure of compiled frequency responses: sizes, non-zero entries, parameters; and arrays packed for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from flexros.identify.frf.sampled import ORDERS
from flexros.identify.graybox.kernel.elimination import Elimination, eliminate

if TYPE_CHECKING:
    from flexros.arrays import BoolArray, ComplexArray, FloatArray
    from flexros.identify.graybox.frequency_model import FrequencyModel
    from flexros.robot.linear.positions import LinearisedPositions

Vector: TypeAlias = "tuple[tuple[int, float], ...]"
"""A rank-one vector as pairs (coordinate, coefficient)."""
NEGLIGIBLE = 1e-14
"""Element relative to the geometric mean of its diagonal elements that is treated as zero."""
LANES = 8
"""Frequencies per block, evaluated together."""


@dataclass(frozen=True)
class KernelStructure:
    """Structure of the code; equal structures share it.

    Attributes:
        n: Number of coordinates.
        motors: Coordinate of each motor, length M.
        entries: Entries (row >= column) of A that are not zero in some position.
        damped: Those of them where D is not zero.
        vectors: Distinct rank-one vectors as pairs (coordinate, coefficient), length J.
        parameters: Index of the vector and power of jw of each parameter, length P; slope g counts as vector J + g
            with power 0.
        n_slopes: Number of parameters that are not rank-one terms, G.
        touched: Coordinates with non-zero entries of slopes.
    """

    n: int
    motors: tuple[int, ...]
    entries: tuple[tuple[int, int], ...]
    damped: tuple[tuple[int, int], ...]
    vectors: tuple[Vector, ...]
    parameters: tuple[tuple[int, int], ...]
    n_slopes: int
    touched: tuple[int, ...]

    @cached_property
    def elimination(self) -> Elimination:
        """Order of elimination and fill-in."""
        return eliminate(self.n, self.entries, self.motors)

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Elements (m, n) of the symmetric response with m <= n, in the order of all packed arrays."""
        return motor_pairs(len(self.motors))

    @cached_property
    def sloped(self) -> range:
        """Pivots between the first and the last coordinate with non-zero entries of slopes."""
        turns = [turn for turn, coordinate in enumerate(self.elimination.order) if coordinate in self.touched]
        return range(turns[0], turns[-1] + 1) if turns else range(0)

    @property
    def matrix_numbers(self) -> int:
        """Numbers per position in packed matrices: K, M, D of entries, then of slopes."""
        return 3 * (len(self.entries) + self.n_slopes * len(self.sloped) ** 2)

    @property
    def factor_numbers(self) -> int:
        """Complex factors of derivatives per frequency: v of each vector, then products of slopes."""
        return len(self.vectors) * len(self.motors) + self.n_slopes * len(self.pairs)

    @property
    def hold_numbers(self) -> int:
        """Numbers per frequency in packed holds: w, gain and aliases."""
        return 3 + 2 * len(ORDERS)


def motor_pairs(n_motors: int) -> tuple[tuple[int, int], ...]:
    """List the elements (m, n) with m <= n of a symmetric matrix, row by row."""
    return tuple((m, n) for m in range(n_motors) for n in range(m, n_motors))


def kernel_structure(positions: LinearisedPositions) -> KernelStructure:
    """Determine the structure of linearised positions, with every entry that a parameter can make non-zero."""
    slopes = (positions.mass_slopes, positions.damping_slopes, positions.stiffness_slopes)
    sloped = [_filled(slope.reshape(-1, *slope.shape[2:])) for slope in slopes]
    touched = np.einsum("pi,pj->ij", np.abs(positions.vectors), np.abs(positions.vectors)) != 0
    damped = touched | sloped[1] | _filled(positions.damping)
    filled = damped | sloped[0] | sloped[2] | _filled(positions.mass) | _filled(positions.stiffness)
    lower = [(i, j) for i in range(len(filled)) for j in range(i + 1)]
    vectors, parameters = _vectors(positions)
    return KernelStructure(
        n=len(filled),
        motors=tuple(int(coordinate) for coordinate in positions.motor_rows),
        entries=tuple(entry for entry in lower if filled[entry] or entry[0] == entry[1]),
        damped=tuple(entry for entry in lower if damped[entry]),
        vectors=vectors,
        parameters=parameters,
        n_slopes=len(positions.sloped),
        touched=tuple(int(coordinate) for coordinate in np.flatnonzero(np.any(sloped, axis=(0, 1)))),
    )


def _filled(matrices: FloatArray) -> BoolArray:
    """Entries above rounding errors in some matrix, shape (n, n): rounding must not change the compiled code."""
    diagonal = np.sqrt(np.abs(np.einsum("qii->qi", matrices)))
    filled: BoolArray = np.any(np.abs(matrices) > NEGLIGIBLE * diagonal[:, :, None] * diagonal[:, None, :], axis=0)
    return filled


def _vectors(positions: LinearisedPositions) -> tuple[tuple[Vector, ...], tuple[tuple[int, int], ...]]:
    """Distinct rank-one vectors, and vector index and power of each parameter."""
    numbers: dict[Vector, int] = {}
    keys = [tuple((int(i), float(vector[i])) for i in np.flatnonzero(vector)) for vector in positions.vectors]
    for key in keys:
        if key:
            numbers.setdefault(key, len(numbers))
    slopes = {int(p): len(numbers) + slope for slope, p in enumerate(positions.sloped)}
    parameters = tuple(
        (slopes[p], 0) if p in slopes else (numbers[key], int(power))
        for p, (key, power) in enumerate(zip(keys, positions.powers, strict=True))
    )
    return tuple(numbers), parameters


def packed_matrices(structure: KernelStructure, positions: LinearisedPositions, theta: FloatArray) -> FloatArray:
    """Pack K, M, D of every position: of the entries, then of the slopes in the order of elimination.

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
    """Pack angular frequency, gain and aliases in blocks of LANES frequencies; the last frequency fills the last block.

    Returns:
        Numbers per block, shape (Q, blocks, 3 + 2 orders, LANES).
    """
    hold = model.hold
    aliases = np.stack([hold.aliases.real, hold.aliases.imag], axis=-1)
    numbers = [hold.omega, hold.gain.real, hold.gain.imag, *np.moveaxis(aliases.reshape(*hold.omega.shape, -1), -1, 0)]
    return in_blocks(np.stack(numbers, axis=-1))


def packed_target(response: ComplexArray, weights: FloatArray, logarithmic: bool) -> FloatArray:
    """Pack measured responses and weights in blocks.

    Args:
        response: Measured responses, shape (Q, F, M, M); arbitrary where the weight is zero.
        weights: Weights, shape (Q, F, M, M).
        logarithmic: Whether logarithms of the responses are compared.

    Returns:
        For each pair (m, n) of motors: measured (m, n) as two numbers, weight; the same of (n, m), with weight 0 where
        m = n; square root of the sum of both weights and its inverse (0 for 0); shape (Q, blocks, 8 pairs, LANES).
    """
    measured = np.where(weights > 0, response, 1.0)
    if logarithmic:
        measured = np.log(measured)
    m, n = np.array(motor_pairs(measured.shape[-1])).T
    second = np.where(m != n, weights[:, :, n, m], 0.0)
    root = np.sqrt(weights[:, :, m, n] + second)
    first, other = measured[:, :, m, n], measured[:, :, n, m]
    numbers = [
        *(first.real, first.imag, weights[:, :, m, n]),
        *(other.real, other.imag, second),
        *(root, np.where(root > 0, 1.0 / np.where(root > 0, root, 1.0), 0.0)),
    ]
    return in_blocks(np.stack(numbers, axis=-1).reshape(*root.shape[:2], -1), fill=0.0)


def in_blocks(numbers: FloatArray, fill: float | None = None) -> FloatArray:
    """Pack numbers per frequency in blocks of frequencies.

    Args:
        numbers: Numbers, shape (Q, F, k).
        fill: Padding of the last block; default: the numbers of the last frequency.

    Returns:
        The numbers, shape (Q, blocks, k, LANES).
    """
    missing = -numbers.shape[1] % LANES
    tail = np.repeat(numbers[:, -1:], missing, axis=1)
    padded = np.concatenate([numbers, tail if fill is None else np.full_like(tail, fill)], axis=1)
    blocks = padded.reshape(len(numbers), -1, LANES, numbers.shape[-1])
    return np.ascontiguousarray(blocks.swapaxes(2, 3))


def out_of_blocks(blocks: FloatArray, n_frequencies: int) -> ComplexArray:
    """Undo `in_blocks` for complex numbers stored as real and imaginary parts in turn.

    Args:
        blocks: Parts, shape (Q, blocks, 2 k, LANES).
        n_frequencies: F.

    Returns:
        Numbers, shape (Q, F, k).
    """
    parts = blocks.swapaxes(2, 3).reshape(len(blocks), -1, blocks.shape[2])[:, :n_frequencies]
    return np.ascontiguousarray(parts).view(np.complex128)
