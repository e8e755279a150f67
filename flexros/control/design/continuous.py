"""Continuous linear systems of the H-infinity designs: series, Pade delay, bilinear transform."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import tf2ss

from flexros.control.design.fixed_structure import DiscreteSystem
from flexros.control.design.linear_system import AbstractLinearSystem
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.design.methods.base import DesignProblem

HELD = 0.5
"""Delay of the hold [samples]; the control law itself acts on the present sample."""


@dataclass(frozen=True, eq=False)
class ContinuousSystem(AbstractLinearSystem):
    """A continuous linear system x' = A x + B u, y = C x + D u."""

    @classmethod
    def of_polynomials(cls, above: Sequence[float], below: Sequence[float]) -> ContinuousSystem:
        """Return a transfer function, given by the coefficients of its polynomials, highest power first."""
        A, B, C, D = (np.asarray(part, dtype=float) for part in tf2ss(above, below))
        return cls(A, B, C, D)

    def response(self, frequency: FloatArray) -> ComplexArray:
        """Return the frequency response, shape (F, n_outputs, n_inputs); frequencies [Hz], shape (F,)."""
        return self.transfer(np.asarray(2j * np.pi * frequency, dtype=complex))


def pade(delay: float) -> ContinuousSystem:
    """Return the Pade approximation of second order of a delay [s] of one signal."""
    a, b = 12.0 / delay**2, 6.0 / delay
    return ContinuousSystem.of_polynomials([1.0, -b, a], [1.0, b, a])


def delayed_plant(problem: DesignProblem, stiffness_share: float, method: str) -> ContinuousSystem:
    """Return the plant of one motor with its delay and that of the hold.

    Args:
        problem: The robot, linearised.
        stiffness_share: Design model between softest (0) and stiffest (1) spring segment.
        method: Name of the method, for the error message.

    Raises:
        InputError: The robot has several motors.
    """
    if problem.robot.n_motors != 1:
        raise InputError(
            f"{method} designs the loop of one motor, but robot {problem.robot.name} has {problem.robot.n_motors}; "
            "choose lqg or pole_placement",
            "model",
        )
    plant = problem.plant_at(stiffness_share)
    bare = ContinuousSystem(plant.A[0], plant.B[0], plant.C[0], np.zeros((len(plant.C[0]), 1)))
    return pade(problem.delay + HELD * problem.sample_time).then(bare)


def tustin(system: ContinuousSystem, sample_time: float) -> DiscreteSystem:
    """Discretise with the bilinear transform, s = 2 / T (z - 1) / (z + 1).

    Args:
        system: The system.
        sample_time: T [s].
    """
    n, k = len(system.A), 2.0 / sample_time
    inverse = np.linalg.inv(k * np.eye(n) - system.A)
    A = inverse @ (k * np.eye(n) + system.A)
    B = 2.0 * k * inverse @ system.B
    C = system.C @ inverse
    return DiscreteSystem(A, B, C, system.D + C @ system.B)
