"""Check for a time offset between torque and motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.balance.regression import coefficients
from flexros.record.balance.torque_balance import AGREED
from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.checks.checked_record import TINY
from flexros.record.checks.thinned_commands import THINNED
from flexros.record.torques.shifted_torque import timing_is_open

if TYPE_CHECKING:
    from flexros.record.checks.checked_record import CheckedRecord

SIGNIFICANT = 5.0
"""Offset over its standard deviation above which it is significant (chosen)."""

DOUBTFUL = 3.8
"""The same for a lead of whole samples that is worth a warning: effects that the model lacks blur the offset, and no
robot moves that long before its torque (chosen; right stamps showed up to 3.6)."""

WHOLE = 1.0
"""Lead from which that holds [samples] (chosen)."""

NOTED, REFUSED = 0.3, 0.6
"""Lead of a motion over its torque, which no robot has, for a warning and for rejection [samples] (chosen)."""

FILTERED = 0.01
"""Lead up to which a filter of measured currents may make it [s] (chosen): one of 16 Hz does."""

EARLIEST = -0.5
"""Samples from the stamp of a torque to the middle of the time in which it acts, where a recorder notes it after it was
held [1]: so much of such a lead may be that of the recorder."""

LESS = 0.1
"""Rise of the mean over the motors of ln(power of the torque that is left) from which an offset is none [1] (chosen):
0.7 to 2.3 where large friction or a wrong centre of mass had imitated one, 0.01 at most for right ones. A delay is one
from this fall of it while motors slide: 0.13 to 7.6 for right ones, 0.03 at most where motors had stuck before."""

FAST, AWAY = 0.1, 0.15
"""Speed over its largest one [1] from which a motor slides, and time from any slower sample [s] (chosen): around a stop
static friction lets torque rise before the motion begins, and filters spread that."""

LARGEST = 0.95
"""Share of speeds that are below what counts as the largest one [1] (chosen)."""

FEWEST = 200
"""Fewest samples in which a motor slides that tell a delay (chosen)."""

EXPLAINED = 0.3
"""Power that friction and the rigid arm leave of a torque, up to which they tell a delay [1] (chosen)."""

LONGEST = 0.01
"""Delay of the torque beyond which an offset between topics is more likely than a delay of the robot [s] (chosen)."""

ALIKE = 0.12
"""Difference of that lead from half of what the controller is faster, up to which thinned commands explain it
[samples] (chosen)."""


class TimeOffset(AbstractCheck):
    """No robot explains a torque stamped later than it acts; a long delay may be an error of the log."""

    name: ClassVar[str] = "time_offset"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Find the shift in time at which torques and inverse-dynamics torques agree best."""
        if checked.order_is_wrong or checked.fits_nominal_rate or checked.wrongly_assigned or checked.balance is None:
            return ()
        tau, T = checked.delay.time, checked.record.sample_time
        declared = 0.0 if checked.record.measured_torque else checked.robot.delay
        early = -tau - declared  # lead of the motion, whatever the delay of the robot
        if _explains_less(checked, tau):
            return ()
        if abs(tau) < SIGNIFICANT * checked.delay.deviation:
            return _doubtful(early, checked) if abs(tau) > DOUBTFUL * checked.delay.deviation else ()
        if early > NOTED * T:
            text = (
                f"the torques are stamped too late: the motions precede them by {1e3 * early:.2g} ms; give "
                f"'time_offset: {-early:.2g}' at the torque columns when importing, so that commands and measurements "
                "of the same instant have the same stamp"
            )
            period = checked.robot.sample_time
            commands = not checked.record.measured_torque  # of measured torques no controller was thinned
            if commands and THINNED * period < T and abs(early - (T - period) / 2) < ALIKE * T:
                text = (
                    f"the motions precede the torques by {1e3 * early:.2g} ms, as where the log holds one of "
                    f"{T / period:.3g} commands of a controller at {1 / period:.6g} Hz, the rate of the robot "
                    "file: then record every command; if the controller is as slow as the log, give "
                    f"'time_offset: {-early:.2g}' at the torque columns when importing"
                )
            noted = checked.record.torque_shift - EARLIEST if timing_is_open(checked.record) else 0.0
            hopeless = early > (REFUSED + noted) * T and _agreement(checked, tau) > AGREED
            if checked.record.imported and not commands and early < FILTERED:
                text += ". A drive that low-passes the currents it states makes them late too, and they imitate effects"
                hopeless = False
            return (Finding(text, hopeless=hopeless, like_parameters=True),)
        if tau > LONGEST and _explains_more_sliding(checked, declared, declared + tau):
            text = (
                f"the torques act {1e3 * tau:.2g} ms later than they are stamped; if that is no delay of the robot, "
                f"give 'time_offset: {tau:.2g}' at the torque columns when importing"
            )
            return (Finding(text, hopeless=False),)
        return ()


def _explains_less(checked: CheckedRecord, delay: float) -> bool:
    """Return whether friction and the motion explain clearly less of the torques at a delay [s] than at their stamps.

    Dry friction of large gears, and a centre of mass that is wrong, turn the phases of slow bands by more than a delay.
    """
    balance = checked.balance
    assert balance is not None
    moving = np.flatnonzero(checked.moves).tolist()
    if not moving:
        return False
    left = np.array([[balance.unexplained(motor, motor, time) for time in (0.0, delay)] for motor in moving])
    before, after = np.log(np.maximum(left, np.finfo(float).tiny)).mean(axis=0)
    return bool(after - before > LESS)


def _explains_more_sliding(checked: CheckedRecord, declared: float, delay: float) -> bool:
    """Return whether friction and the rigid arm explain clearly more of the torques at a delay while motors slide.

    In phases of spectra a motor that sticks before it moves looks like one that follows its torque late. True also
    where the rigid arm explains no motor's torque well enough to tell.

    Args:
        checked: The record.
        declared: Delay of the robot file [s].
        delay: The delay in question [s].
    """
    T = checked.record.sample_time
    stamps = checked.slow_samples * T
    torques, arms, drives = checked.slow_parts
    falls = []
    for motor in np.flatnonzero(checked.moves).tolist():
        speed = np.abs(drives[:, motor, 0])
        slow = speed < FAST * np.quantile(speed, LARGEST)
        sliding = np.convolve(slow, np.ones(2 * round(AWAY / (checked.slow_step * T)) + 1), "same") < 0.5
        if sliding.sum() < FEWEST:
            continue
        parts = np.column_stack([arms[sliding, motor], drives[sliding, motor]])
        powers = []
        for time in (declared, delay):
            torque = np.interp(stamps[sliding] - time, stamps, torques[:, motor])
            powers.append(np.var(torque - parts @ coefficients(parts, torque)) / max(np.var(torque), TINY**2))
        if powers[0] < EXPLAINED:
            falls.append(np.log((powers[0] + TINY**2) / (powers[1] + TINY**2)))
    return not falls or bool(np.mean(falls) > LESS)


def _doubtful(early: float, checked: CheckedRecord) -> tuple[Finding, ...]:
    """Warn of motions that seem to precede their torques by whole samples [s], which no robot does."""
    if early < WHOLE * checked.record.sample_time:
        return ()
    text = (
        f"the motions seem to precede the torques by {1e3 * early:.2g} ms ({early / checked.delay.deviation:.2g} times "
        "its standard deviation), which no robot does: torques that are stamped too late hide and imitate effects; "
        f"compare the clocks, and if that is so give 'time_offset: {-early:.2g}' at the torque columns when importing"
    )
    return (Finding(text, hopeless=False),)


def _agreement(checked: CheckedRecord, delay: float) -> float:
    """Return the mean agreement of the torques with the inverse-dynamics torques at a delay [s]."""
    assert checked.balance is not None
    moving = np.flatnonzero(checked.moves).tolist()
    fits = [checked.balance.fit(motor, motor, delay) for motor in moving]
    return float(np.mean([0.0 if fit is None else fit.agreement for fit in fits])) if fits else 0.0
