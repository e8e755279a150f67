"""A control law linearised about rest, away from its limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.control.context import LINK_MOTION
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.control.context import LoopContext

_LONGEST, _STILL = 4000, 1e-9
"""Samples after which a law counts as being at rest, and relative change of its states that does (chosen)."""


@dataclass(frozen=True, eq=False)
class LinearController:
    """A sampled feedback controller about rest, away from its limits; m is the number of its states.

    u = from_state c + from_reference r + from_measured y, next c = state_step c + state_reference r + state_measured y,
    with r in the order
    of `LoopContext.references` and y in that of `LoopContext.measurements`.

    Attributes:
        from_state: Shape (M, m).
        from_reference: Shape (M, 3 M).
        from_measured: Shape (M, n_measured).
        state_step: Shape (m, m).
        state_reference: Shape (m, 3 M).
        state_measured: Shape (m, n_measured).
        link_columns: First column of the link positions among the references; None where there is none.
    """

    from_state: FloatArray
    from_reference: FloatArray
    from_measured: FloatArray
    state_step: FloatArray
    state_reference: FloatArray
    state_measured: FloatArray
    link_columns: int | None = None

    def position_columns(self, motor: int) -> list[int]:
        """Return the references that a step of a motor and its link moves."""
        return [motor] if self.link_columns is None else [motor, self.link_columns + motor]


def linear_controller(
    law: AbstractControlLaw, context: LoopContext, rest: tuple[FloatArray, FloatArray] | None = None
) -> LinearController:
    """Linearise a controller away from its limits; exact for a sampled linear law.

    Args:
        law: The controller.
        context: Robot, sample time and signals of the loop.
        rest: References and measurements of the robot at rest about which it is linearised, shapes
            (context.references.size,) and (context.measurements.size,); default: zeros, which is enough for a linear
            law. States that only come to rest in time, such as the covariance of a filter, are run until they do.

    Returns:
        Its matrices.
    """
    function = law.function(context)
    c, r, y = (ca.SX.sym(name, function.size1_in(index)) for index, name in enumerate("cry"))
    gains = law.gains(context)
    u, after = function(c, r, y, gains)
    parts = [ca.densify(ca.jacobian(out, part)) for out in (u, after) for part in (c, r, y)]
    at = rest or (np.zeros(function.size1_in(1)), np.zeros(function.size1_in(2)))
    started = np.asarray(function(law.initial_state(context), *at, gains)[1], dtype=float).ravel()
    for _ in range(_LONGEST if rest is not None else 0):
        before, started = started, np.asarray(function(started, *at, gains)[1], dtype=float).ravel()
        if np.all(np.abs(started - before) <= _STILL * np.abs(before)):
            break
    evaluate = ca.Function("linearised", [c, r, y], parts)
    from_c, from_r, from_y, of_c, of_r, of_y = (np.asarray(part, float) for part in evaluate(started, *at))
    links = context.references.rows(LINK_MOTION[0]).start if context.link_motion else None
    return LinearController(from_c, from_r, from_y, of_c, of_r, of_y, links)


def connected(controller: LinearController) -> LinearController:
    """Return a controller without states that measurements cannot move or that the torques do not show.

    Such states, e.g. the integral part of a PID with ki = 0, have eigenvalues that say nothing of the loop.

    Args:
        controller: The controller.
    """
    moves = controller.state_step != 0.0
    moved, shown = np.any(controller.state_measured != 0.0, axis=1), np.any(controller.from_state != 0.0, axis=0)
    for _ in range(len(moves)):
        moved, shown = moved | (moves @ moved), shown | (moves.T @ shown)
    kept = moved & shown
    return replace(
        controller,
        from_state=controller.from_state[:, kept],
        state_step=controller.state_step[np.ix_(kept, kept)],
        state_reference=controller.state_reference[kept],
        state_measured=controller.state_measured[kept],
    )


def encoder_controller(law: AbstractControlLaw, context: LoopContext) -> LinearController:
    """Linearise a controller that uses the motor encoders alone; its y are the motor positions.

    Args:
        law: The controller.
        context: Robot, sample time and signals of the loop.

    Returns:
        Its matrices.

    Raises:
        InputError: It uses other sensors than the motor encoders, or follows the motion of the links.
    """
    if law.follows_link_motion:
        raise InputError(
            f"the linear loop of controller {law.kind} is not known, because it follows the motion of the links; "
            "choose a controller of the motor positions"
        )
    whole = linear_controller(law, context)
    motors = context.measurements.rows("motor_position")
    if np.any(np.delete(np.vstack([whole.from_measured, whole.state_measured]), motors, axis=1)):
        raise InputError(
            f"the linear loop of controller {law.kind} is computed from the motor encoders alone, but it uses other "
            "sensors too; choose a controller of the motor positions"
        )
    return replace(whole, from_measured=whole.from_measured[:, motors], state_measured=whole.state_measured[:, motors])
