"""Gain of a design over positions chosen at random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray

RANDOM_SETS = 200
"""Sets of random positions to compare with (chosen)."""


@dataclass(frozen=True, eq=False)
class DesignGain:
    """A design compared with random sets of as many experiments; standard deviations are relative to the parameters.

    Attributes:
        efficiency: (det of the design / det of the optimal shares)^(1/P).
        random_efficiency: The same of the random sets, ascending, shape (R,).
        deviation: Predicted standard deviation of each parameter, shape (P,).
        random_deviation: Median of it over the random sets, shape (P,).
    """

    efficiency: float
    random_efficiency: FloatArray
    deviation: FloatArray
    random_deviation: FloatArray

    @property
    def experiments_saved(self) -> float:
        """Factor by which a random set of median efficiency needs more experiments than the design."""
        return self.efficiency / float(np.median(self.random_efficiency))


def design_gain(
    information: FloatArray,
    counts: IntArray,
    optimum: float,
    seed: int,
    number: int = RANDOM_SETS,
    prior: FloatArray | None = None,
) -> DesignGain:
    """Compare a design with sets of positions drawn at random from the candidates, without repetition.

    Args:
        information: Information of one experiment in each candidate, logarithmic parameters, shape (Q, P, P).
        counts: Experiments of the design in each candidate, shape (Q,).
        optimum: log det of the information per experiment of the optimal shares.
        seed: Seed of the random sets.
        number: Number of random sets.
        prior: Information before any experiment, on the scale of one experiment, shape (P, P); default: none.

    Returns:
        The comparison.
    """
    total, size = int(counts.sum()), information.shape[1]
    before = np.zeros((size, size)) if prior is None else prior
    generator = np.random.default_rng(seed)
    sets = [generator.choice(len(information), total, replace=total > len(information)) for _ in range(number)]
    random = np.array([before + information[chosen].mean(axis=0) for chosen in sets])
    design = before + np.tensordot(counts / total, information, axes=1)
    return DesignGain(
        efficiency=float(_efficiency(design, optimum)),
        random_efficiency=np.sort(_efficiency(random, optimum)),
        deviation=predicted_deviation(total * design),
        random_deviation=np.median(predicted_deviation(total * random), axis=0),
    )


def predicted_deviation(information: FloatArray) -> FloatArray:
    """Return the standard deviations that an information matrix allows (Cramér-Rao bound).

    Args:
        information: Information, shape (..., P, P).

    Returns:
        Standard deviations, infinite where nothing is known, shape (..., P).
    """
    size = np.sqrt(np.diagonal(information, axis1=-2, axis2=-1))
    safe = np.where(size > 0, size, 1.0)
    scaled = information / safe[..., :, None] / safe[..., None, :]
    regular = np.linalg.eigvalsh(scaled)[..., 0] > 1e-14
    inverse = np.linalg.inv(np.where(regular[..., None, None], scaled, np.eye(information.shape[-1])))
    deviation = np.sqrt(np.diagonal(inverse, axis1=-2, axis2=-1)) / safe
    result: FloatArray = np.where(regular[..., None] & (size > 0), deviation, np.inf)
    return result


def _efficiency(matrices: FloatArray, optimum: float) -> FloatArray:
    sign, value = np.linalg.slogdet(matrices)
    result: FloatArray = np.where(sign > 0, np.exp((value - optimum) / matrices.shape[-1]), 0.0)
    return result
