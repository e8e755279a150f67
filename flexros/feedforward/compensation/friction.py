"""Friction compensation: the torque that the feedforward adds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.config.per_motor import per_motor

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.feedforward.specification import FrictionCompensation

NAMES = ("viscous", "coulomb", "stribeck", "stribeck_velocity", "smoothing_velocity")


def friction_torque(friction: FrictionCompensation, velocity: FloatArray) -> FloatArray:
    """Evaluate viscous, Coulomb and Stribeck friction at the reference speed.

    tau_f = viscous v + (coulomb + stribeck exp(-(v / v_s)^2)) tanh(v / v_0), after Moberg (2007), section 3.2.3, with
    the sign smoothed (chosen): otherwise a reference at rest would switch the torque by round-off. Friction acts
    between motor and gear, so the compensation adds to the motor torque and does not change the solution of the DAE
    (Paper B, section 7).

    Args:
        friction: Coefficients.
        velocity: Motor speeds [rad/s or m/s], shape (n, M).

    Returns:
        Torque [Nm or N], shape (n, M).

    Raises:
        InputError: A coefficient has neither one value nor one value per motor.
    """
    n_motors = velocity.shape[1]
    values = {name: per_motor(f"feedforward.friction.{name}", getattr(friction, name), n_motors) for name in NAMES}
    v, c = ca.SX.sym("v"), ca.SX.sym("c", len(NAMES))
    viscous, coulomb, stribeck, v_s, v_0 = (c[i] for i in range(len(NAMES)))
    value = viscous * v + (coulomb + stribeck * ca.exp(-((v / v_s) ** 2))) * ca.tanh(v / v_0)
    law = ca.Function("friction", [v, c], [value])
    columns = np.stack([values[name] for name in NAMES])
    torque = np.empty_like(velocity)
    for i in range(n_motors):
        torque[:, i] = np.array(law(velocity[:, [i]].T, np.tile(columns[:, [i]], len(velocity)))).ravel()
    return torque
