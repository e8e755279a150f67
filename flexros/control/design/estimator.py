"""Controllers from state feedback and an estimator, with the disturbance torque as a state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.control.design.fixed_structure import DiscreteSystem

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.design.plants import SampledPlants


def disturbance_plant(plant: SampledPlants) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Append a disturbance torque at each motor, which does not change, as states.

    Args:
        plant: One sampled plant.

    Returns:
        A, B, C of the states [plant with its delay, disturbance (M)].
    """
    n, motors = plant.B.shape[1:]
    A = np.block([[plant.A[0], plant.G[0][:, :motors]], [np.zeros((motors, n)), np.eye(motors)]])
    B = np.vstack([plant.B[0], np.zeros((motors, motors))])
    return A, B, np.hstack([plant.C[0], np.zeros((len(plant.C[0]), motors))])


def estimator_controller(
    A: FloatArray, B: FloatArray, C: FloatArray, feedback: FloatArray, gain: FloatArray
) -> DiscreteSystem:
    """Return the controller u = -K xc with the estimate xc = x + M (y - C x), x+ = A xc + B u.

    The estimate uses the present measurement. The input is the error e = -y of a regulator at rest.

    Args:
        A: System matrix of the estimator's plant, shape (n, n).
        B: Input matrix, shape (n, M).
        C: Output matrix, shape (n_measured, n).
        feedback: K, shape (M, n).
        gain: M, shape (n, n_measured).
    """
    corrected = np.eye(len(A)) - gain @ C
    closed = A - B @ feedback
    return DiscreteSystem(closed @ corrected, -closed @ gain, -feedback @ corrected, feedback @ gain)
