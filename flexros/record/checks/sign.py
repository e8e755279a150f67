"""Check for inverted torques or positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.record.balance.torque_balance import BalanceFit
    from flexros.record.checks.checked_record import CheckedRecord

CLEAR = 0.5
"""Agreement of the inverted torque with the inverse-dynamics torque above which a sign is wrong (chosen)."""

OPPOSITE, LEAST_SHARE = -0.9, 0.1
"""Correlation of both below which a sign is wrong, where friction leaves at least this share of the torque (chosen).
Torque sensors behind the gear count the load, which is opposite to the torque of the motor; there the bands above
gravity hold noise alone, so that their agreement is low. What little a torque of friction leaves may correlate so by
chance."""


class Sign(AbstractCheck):
    """An inverted torque or position gives the inverse-dynamics torque the opposite sign at all frequencies."""

    name: ClassVar[str] = "sign"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find negative factors between torque and inverse-dynamics torque."""
        if checked.order_is_wrong or checked.wrongly_assigned:
            return ()
        motors = [motor for motor, fit in enumerate(checked.own) if fit is not None and fit.factor < 0]
        inverted = [motor for motor in motors if _clear(checked.own[motor])]
        if not inverted:
            return ()
        if len(motors) == sum(fit is not None for fit in checked.own):
            inverted = motors  # those that are less clear count the same way
        if checked.assignment is not None and checked.assignment.agreement > _with_inverted(checked.own, inverted):
            return ()  # such as the zero of a joint elsewhere, which turns the weight of others round
        names = ", ".join(checked.robot.joint_names[motor] for motor in inverted)
        text = (
            f"torque and motion of {names} have opposite directions compared with robot "
            f"{checked.robot.name}: the sign of torque or encoder is inverted; correct it (sign: -1) when importing"
        )
        return (Finding(text, hopeless=True),)


def _with_inverted(fits: Sequence[BalanceFit | None], inverted: Sequence[int]) -> float:
    """Return the mean agreement without factors if the torques of some motors are inverted."""
    signs = np.where(np.isin(np.arange(len(fits)), inverted), -1.0, 1.0)
    return float(np.mean([sign * fit.as_is for sign, fit in zip(signs, fits, strict=True) if fit is not None]))


def _clear(fit: BalanceFit | None) -> bool:
    """Return whether a negative factor is clear enough to be that of an inverted signal."""
    if fit is None:
        return False
    return fit.agreement > CLEAR or (fit.correlation < OPPOSITE and fit.share > LEAST_SHARE)
