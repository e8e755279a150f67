"""The classical fourth-order Runge-Kutta step (Kutta 1901) as a CasADi function."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import casadi as ca

if TYPE_CHECKING:
    from flexros.compile.loop.functions import LoopFunctions

Symbol = TypeVar("Symbol", ca.SX, ca.MX)
MERGED_INSTRUCTIONS = 1500  # a derivative up to this length is written out four times, which compiles in 0.05 s


def step_weights(h: float) -> tuple[float, float, float]:
    """Return the weights (h, h/2, h/6) of a step of length h [s]."""
    return h, 0.5 * h, h / 6.0


def runge_kutta_step(functions: LoopFunctions, symbol: type[Symbol]) -> ca.Function:
    """Build (x, u, w, p, weights) -> x one step later; u, w and p are held.

    Args:
        functions: The loop, of which `derivative` is used.
        symbol: casadi.SX writes the derivative out four times, casadi.MX calls it.
    """
    f = functions.derivative
    x, u, w, p = (symbol.sym(name, f.numel_in(k)) for k, name in enumerate("xuwp"))
    weights = symbol.sym("weights", 3)
    h, half, sixth = weights[0], weights[1], weights[2]
    k1 = f(x, u, w, p)
    k2 = f(x + half * k1, u, w, p)
    k3 = f(x + half * k2, u, w, p)
    k4 = f(x + h * k3, u, w, p)
    after = x + sixth * (((k1 + (k2 + k2)) + (k3 + k3)) + k4)
    return ca.Function("runge_kutta_step", [x, u, w, p, weights], [after])


def whole_step(functions: LoopFunctions) -> ca.Function | None:
    """Return the step of a loop as one function to compile; None where the derivative is too long to be written out."""
    if functions.step is not None:
        return functions.step
    derivative = functions.derivative
    short = derivative.is_a("SXFunction") and derivative.n_instructions() <= MERGED_INSTRUCTIONS
    return runge_kutta_step(functions, ca.SX) if short else None
