"""Check for inverted torques or positions."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.balance.regression import coefficients
from flexros.record.checks.base import AbstractCheck, Finding

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.record.balance.torque_balance import BalanceFit
    from flexros.record.checks.checked_record import CheckedRecord

CLEAR, AGAINST, CERTAIN = 0.5, -0.7, 0.8
"""Agreement of the inverted torque with the inverse-dynamics torque above which a sign is wrong, and correlation below
which it is so up to the third number (chosen). On measured robots whose torques agree as well the correlation is -0.85
and less where these are inverted; -0.51 on one with the right sign whose masses are wrong."""

OPPOSITE, LEAST_SHARE = -0.9, 0.1
"""Correlation of both below which a sign is wrong, where friction leaves at least this share of the torque (chosen).
Torque sensors behind the gear count the load, which is opposite to the torque of the motor; there the bands above
gravity hold noise alone, so that their agreement is low. What little a torque of friction leaves may correlate so by
chance."""

BRAKES = -0.1
"""Correlation of a torque with its speed below which the motion drives the motor (chosen): friction makes it positive,
and what weight and inertia give back over a log of moves to and fro is about zero. So it must be beside what the bodies
need too: a joint that others swing is braked by its motor with the right sign."""

LEAST_BRAKE, AS_SPEED = 0.1, -0.5
"""Power of what goes with the speed and its sign over that of the torque, and correlation of it with the speed, from
which friction of the wrong sign is clear (chosen)."""

UNLIKE = 0.3
"""Agreement of torque and inverse-dynamics torque below which the model explains nothing that speaks for the sign
(chosen)."""

BESIDE_FRICTION = 20.0
"""Frequency up to which the inverse-dynamics torque beside that friction needs the motion [Hz] (chosen)."""


class Sign(AbstractCheck):
    """An inverted torque or position gives the inverse-dynamics torque the opposite sign at all frequencies.

    Where friction dominates, as at light wrists, little of the inverse-dynamics torque is left to compare: there the
    torque brakes the motion that it should drive.
    """

    name: ClassVar[str] = "sign"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find negative factors between torque and inverse-dynamics torque."""
        if checked.order_is_wrong or checked.wrongly_assigned or checked.postures:
            return ()
        motors = [motor for motor, fit in enumerate(checked.own) if fit is not None and fit.factor < 0]
        inverted = [motor for motor in motors if _clear(checked.own[motor])]
        if not inverted:
            return _braked(checked)
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


def _braked(checked: CheckedRecord) -> tuple[Finding, ...]:
    """Find motors whose torque brakes their motion, though nothing but a wrong sign or an outside force does that."""
    names = [
        checked.robot.joint_names[motor]
        for motor, fit in enumerate(checked.own)
        if fit is not None and fit.as_is < UNLIKE and _brakes(checked, motor)
    ]
    if not names:
        return ()
    text = (
        f"the torque of {', '.join(names)} brakes the motion that it should drive, as friction of the wrong sign "
        "would: the sign of torque or encoder is inverted there; correct it (sign: -1) when importing, or leave out "
        "what was recorded while something else moved the joint. Where neither sign is right, the torque is that of "
        f"another joint or of none: let its measured motion drive the model (--prescribed {','.join(names)})"
    )
    return (Finding(text, hopeless=True),)


def _brakes(checked: CheckedRecord, motor: int) -> bool:
    """Return whether a torque goes against the speed of its motor, beside weight and inertia of any size."""
    valid = checked.record.valid
    position, speed, acceleration = checked.motion[:, valid, motor]
    torque = checked.record.torque[valid, motor]
    if not _correlation(torque, speed) < BRAKES:
        return False
    arm = checked.rigid_torque(BESIDE_FRICTION)[valid, motor]
    if not _correlation(torque - arm, speed) < BRAKES:
        return False  # other joints drive it, and its motor takes their power
    weight = np.column_stack([arm, np.ones_like(arm), np.cos(position), np.sin(position), acceleration])
    regressors = np.column_stack([weight, speed, np.sign(speed)])
    friction = regressors[:, -2:] @ coefficients(regressors, torque)[-2:]
    share = float(np.sum(friction**2) / np.maximum(np.sum((torque - torque.mean()) ** 2), 1e-300))
    return share > LEAST_BRAKE and _correlation(friction, speed) < AS_SPEED


def _correlation(first: FloatArray, second: FloatArray) -> float:
    """Return the cosine between two signals, 0 where one of them is zero."""
    size = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(first @ second) / size if size > 0 else 0.0


def _with_inverted(fits: Sequence[BalanceFit | None], inverted: Sequence[int]) -> float:
    """Return the mean agreement without factors if the torques of some motors are inverted."""
    signs = np.where(np.isin(np.arange(len(fits)), inverted), -1.0, 1.0)
    return float(np.mean([sign * fit.as_is for sign, fit in zip(signs, fits, strict=True) if fit is not None]))


def _clear(fit: BalanceFit | None) -> bool:
    """Return whether a negative factor is clear enough to be that of an inverted signal."""
    if fit is None:
        return False
    agrees = fit.agreement > (CLEAR if fit.correlation < AGAINST else CERTAIN)
    return agrees or (fit.correlation < OPPOSITE and fit.share > LEAST_SHARE)
