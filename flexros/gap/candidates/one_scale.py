"""Gains of torques, and the inertias that a log of torques hardly tells from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.motor_inertia_error import MotorInertiaError
from flexros.effects.payload_error import PayloadError
from flexros.effects.torque_gain_error import TorqueGainError

if TYPE_CHECKING:
    from flexros.gap.candidates.candidate import Candidate

INERTIAS = (MotorInertiaError, PayloadError)
"""Errors of what a torque accelerates."""


def of_one_scale(one: Candidate, other: Candidate) -> bool:
    """Return whether one of two candidates is a gain of a torque, and the other one an inertia that this moves."""
    gain, inertia = (one, other) if one.effect is TorqueGainError else (other, one)
    moved = inertia.effect in INERTIAS and inertia.location in (gain.location, "tool")
    return gain.effect is TorqueGainError and moved
