"""Limiting a command whose integral part must not wind up."""

from __future__ import annotations

import casadi


def limit_with_integral(
    rest: casadi.SX, integral_before: casadi.SX, increment: casadi.SX, limit: casadi.SX
) -> tuple[casadi.SX, casadi.SX]:
    """Add the integral, limit the sum, and stop integrating while that would drive it further out.

    This is conditional integration. Back-calculation was not taken, because the feedforward torque is added before
    the limit: whenever the feedforward alone reaches the limit, back-calculation would charge the integral with a
    torque that the feedback never asked for, and release it on the path afterwards.

    Args:
        rest: Command without its integral part [Nm], (M, 1).
        integral_before: Integral part of the sample before [Nm], (M, 1).
        increment: What this sample adds to the integral part [Nm], (M, 1).
        limit: Largest command either way [Nm], infinite for none, (M, 1).

    Returns:
        Command and integral part of this sample [Nm].
    """
    integrated = integral_before + increment
    wanted = rest + integrated
    winding_up = casadi.logic_and(casadi.fabs(wanted) > limit, increment * wanted > 0.0)
    integral = casadi.if_else(winding_up, integral_before, integrated)
    return casadi.fmax(-limit, casadi.fmin(limit, rest + integral)), integral
