"""Check for wrong units, and for signals of the wrong side of the gear."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.record.balance.regression import coefficients
from flexros.record.balance.spectra import rotor_unknown
from flexros.record.checks.base import AbstractCheck, Finding
from flexros.record.checks.checked_record import TINY
from flexros.record.checks.degrees import like_degrees

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.record.balance.torque_balance import BalanceFit
    from flexros.record.checks.checked_record import CheckedRecord
    from flexros.robot import Robot

CLEAR = 0.6
"""Agreement above which any factor between torque and inverse-dynamics torque is significant (chosen)."""

LARGE_CLEAR, LARGE_GAIN = 0.4, 0.3
"""Agreement, and its gain by the factor, above which a factor beyond `REFUSED` is significant (chosen)."""

NOTED = 2.0
"""Factor for a warning: errors of gain, inertia and payload of realistic size are below (chosen)."""

REFUSED = 2.7
"""Factor for rejection of a log (chosen)."""

BARE = 5.0
"""Factor up to which rotors and friction explain the largest torque of an arm whose file leaves rotors out, and a load
that of a joint beyond others whose torques fit (chosen)."""

LOADED = 50.0
"""Factor up to which a load that the model lacks explains the torque of a light wrist (chosen)."""

HEAVY = 0.01
"""Power of the torque that a joint needs, over the largest one, from which it is no light wrist (chosen): of such
joints those count whose torques agree, as the friction of the largest one may hide it."""

FEWEST = 2
"""Fewest motors of an arm whose last ones are light (chosen)."""

SHARED, AS_SHARE = 0.8, 1.15
"""Agreement of a torque with a multiple of the inverse-dynamics torque from which its factor tells the unit, and how
far the factor may be from a share of the limit (chosen): errors of gain, inertia and payload of realistic size."""

AS_WELL, ROTOR = 1.5, 2
"""Power that is left of a torque with the factor one, over what is left with any, up to which that explains it as well
[1] (chosen); place of the rotor in `CheckedRecord.slow_parts`."""

LIKE = 1.3
"""Factor within which a level is attributed to a known mistake (chosen)."""


class Unit(AbstractCheck):
    """A wrong unit, gear ratio or robot appears as one factor between torque and inverse-dynamics torque."""

    name: ClassVar[str] = "unit"
    stage: ClassVar[int] = 2

    def look(self, checked: CheckedRecord) -> tuple[Finding, ...]:
        """Compare the level of the torques with that of the inverse-dynamics torques."""
        if checked.order_is_wrong or checked.fits_nominal_rate or checked.wrongly_assigned:
            return ()
        robot = checked.robot
        beside = _factors_beside_drives(checked)
        compared = {k: fit for k, fit in enumerate(checked.own) if fit is not None and beside.get(k) != 1.0}
        off = {
            motor: fit
            for motor, fit in compared.items()
            if fit.factor > 0 and _is_significant(fit) and abs(np.log(fit.factor)) > np.log(NOTED)
        }
        if text := _share_of_limits(checked):
            return (Finding(text, hopeless=True, like_parameters=True),)
        refused = {motor: fit for motor, fit in off.items() if abs(np.log(fit.factor)) > np.log(REFUSED)}
        refused = {k: fit for k, fit in refused.items() if k not in beside or abs(np.log(beside[k])) > np.log(BARE)}
        if refused and not _model_may_be_rough(checked, refused, beside):
            common = _common_causes(refused, robot)
            text = "" if common else like_degrees(checked)  # friction and weight blur the factor of single motors
            if text:
                return (Finding(text, hopeless=True),)
            text = _refusal(refused, common, robot, len(robot.joint_names))
            return (Finding(text, hopeless=True, like_parameters=True),)
        return tuple(
            Finding(
                f"the torque of {robot.joint_names[motor]} is {fit.factor:.3g} times what robot {robot.name} needs for "
                "its motion at all frequencies; unless the model is wrong, as by a load that it lacks, correct torque "
                "constant or gear ratio when importing",
                hopeless=False,
                of_either=True,
            )
            for motor, fit in off.items()
        )


def _factors_beside_drives(checked: CheckedRecord) -> dict[int, float]:
    """Return the factors of what bodies need beside friction, a rotor and an offset of any size, by motor [1].

    Where a joint carries little, those may be many times what its bodies need, as in a short or slow motion. The factor
    is 1 where that leaves about as little of the torque as any other one. Empty where what bodies need does not show in
    such torques: then any unit would do.
    """
    rotors, factors, shown = rotor_unknown(checked.robot), dict[int, float](), 1.0
    for motor in (k for k, fit in enumerate(checked.own) if fit is not None):
        torque, arm, every = (one[:, motor] for one in checked.slow_parts)
        parts = every if rotors[motor] else np.delete(every, ROTOR, axis=1)
        together = np.column_stack([parts, arm])
        as_is = _left(torque - arm, parts)
        if as_is < AS_WELL * _left(torque, together):
            factors[motor] = 1.0
            shown *= _left(torque, parts) / as_is
        else:
            factors[motor] = max(float(coefficients(together, torque)[-1]), TINY)
    return factors if shown > AS_WELL else {}


def _left(torque: FloatArray, parts: FloatArray) -> float:
    """Return the power of a torque that parts of any size leave."""
    return float(np.var(torque - parts @ coefficients(parts, torque)))


def _share_of_limits(checked: CheckedRecord) -> str:
    """Return what is wrong where all clear torques are the same share of limits that differ; empty where they are not.

    A common factor, or one of a single motor, has many causes; factors that follow the limits of the robot file have
    one, also where each is as small as an error of a model may be.
    """
    robot = checked.robot
    limits = np.array([motor.torque_limit for motor in robot.motors])
    clear = [k for k, fit in enumerate(checked.own) if fit is not None and fit.factor > 0 and fit.agreement > SHARED]
    clear = [k for k in clear if np.isfinite(limits[k])]
    if len(clear) < FEWEST or np.ptp(np.log(limits[clear])) < np.log(LIKE):
        return ""
    factors = np.array([fit.factor for k, fit in enumerate(checked.own) if fit is not None and k in clear])
    for share, name in ((100.0, "per cent"), (1000.0, "permille")):
        expected = share / limits[clear]
        if np.all(np.abs(np.log(factors / expected)) < np.log(AS_SHARE)) and np.all(factors > AS_SHARE):
            named = ", ".join(f"{robot.joint_names[k]}: {one:.3g}" for k, one in zip(clear, factors, strict=True))
            return (
                f"the torques are multiples of what robot {robot.name} needs for the motion ({named}), as torques in "
                f"{name} of its limits would be; give unit and scale of each column when importing, as 'unit: percent' "
                f"with 'scale: {{value: {limits[clear[0]] / share:g}, unit: Nm/percent}}'"
            )
    return ""


def _model_may_be_rough(checked: CheckedRecord, refused: dict[int, BalanceFit], beside: Mapping[int, float]) -> bool:
    """Return whether a model of an arm may lack a load, or rotors, at light wrists: joints with large torques fit it.

    A load at the tool multiplies the torque of light wrists, and hardly that of the joints near the base; a wrong unit
    multiplies all of them. That holds of weights and, without gravity, of inertias. A wrist that the motion loads most
    may be no light one: what a load adds there is no more than what it adds nearer to the base.

    Args:
        checked: The record.
        refused: Factors to reject the log for.
        beside: Factors beside friction and rotors, by motor [1].
    """
    balance = checked.balance
    if balance is None or checked.robot.n_motors < FEWEST:
        return False
    if any(fit.factor > LOADED or fit.factor < 1 for fit in refused.values()):
        return False
    power = np.sum(np.abs(balance.needed) ** 2, axis=0)
    power = np.array([0.0 if fit is None else power[motor] for motor, fit in enumerate(checked.own)])
    large = np.flatnonzero(power > HEAVY * power.max()).tolist()
    bare = rotor_unknown(checked.robot)
    clear = {k: fit.factor for k in large if (fit := checked.own[k]) is not None and fit.agreement > LARGE_CLEAR}
    clear = {k: min(factor, beside.get(k, factor), key=lambda one: abs(np.log(one))) for k, factor in clear.items()}
    if not clear:
        return False
    base, added = min(clear), 0.0  # what a load multiplies is farther out
    for k, factor in clear.items():
        here = (factor - 1) * float(np.sqrt(power[k]))
        most = BARE if bare[k] or k > base else REFUSED
        if factor < 1 / REFUSED or (factor > most and (k == base or here > added)):
            return False
        added = max(added, here)
    return True


def _is_significant(fit: BalanceFit) -> bool:
    """Return whether the factor of a comparison is significant."""
    if fit.agreement > CLEAR:
        return True
    refused = abs(np.log(fit.factor)) > np.log(REFUSED)
    return bool(refused) and fit.agreement > LARGE_CLEAR and fit.agreement - fit.as_is > LARGE_GAIN


def _common_causes(off: dict[int, BalanceFit], robot: Robot) -> list[str]:
    """List the mistakes that explain the factors of most motors; friction moves those of single ones."""
    causes = [cause(fit.factor, robot, motor) for motor, fit in off.items()]
    every = dict.fromkeys(text for texts in causes for text in texts)
    return [text for text in every if sum(text in texts for texts in causes) > len(causes) / 2]


def _refusal(off: dict[int, BalanceFit], common: list[str], robot: Robot, n_motors: int) -> str:
    names = ", ".join(f"{robot.joint_names[motor]}: {fit.factor:.3g}" for motor, fit in off.items())
    likely = f"it looks like {' or '.join(common)}" if common else "the torques or the motions have another unit"
    sizes = np.abs(np.log([fit.factor / next(iter(off.values())).factor for fit in off.values()]))
    if not common and len(off) == n_motors > 1 and sizes.max() > np.log(LIKE):
        likely = "all motors differ, so it looks like another robot"
    elif not common and n_motors == 1:
        likely = "torque or motion have another unit, or the robot is another one"
    return (
        f"the torques are a multiple of what robot {robot.name} needs for the motion ({names}), allowed is a factor of "
        f"{REFUSED:g} either way: {likely}; correct unit, gear ratio or torque constant when importing, or give the "
        "right robot"
    )


def cause(factor: float, robot: Robot, motor: int) -> list[str]:
    """List the mistakes that explain a factor between torque and inverse-dynamics torque.

    Args:
        factor: Torque over inverse-dynamics torque [1].
        robot: The nominal robot.
        motor: Number of the motor (0-based).

    Returns:
        Mistakes with about that factor, the likeliest first.
    """
    limit = robot.motors[motor].torque_limit
    known = _units(robot, motor)
    if np.isfinite(limit):
        known += [
            (share / limit, f"torques in {text} of the limit") for share, text in ((100, "%"), (1000, "permille"))
        ]
    near = [(abs(np.log(factor / value)), text) for value, text in known if abs(np.log(factor / value)) < np.log(LIKE)]
    return list(dict.fromkeys(text for _, text in sorted(near)))


def _units(robot: Robot, motor: int) -> list[tuple[float, str]]:
    """List factors between units and between the sides of a gear."""
    size = robot.motors[motor].gear_ratio
    known = [
        (1e-3, "a unit with milli (positions) or kilo (torques)"),
        (1e3, "a unit with milli (torques) or kilo (positions)"),
    ]
    if robot.motors[motor].rotary:
        known += [
            (1 / np.degrees(1.0), "positions in degrees instead of radians"),
            (np.degrees(1.0), "positions converted from degrees to radians twice"),
            (2 * np.pi, "positions in turns instead of radians"),
        ]
    if size > 1:
        known += [
            (1 / size, f"one of torque and position on the other side of the gear (ratio {size:g})"),
            (size, f"one of torque and position on the other side of the gear (ratio {size:g})"),
            (1 / size**2, f"torque and position on the motor side of the gear (ratio {size:g})"),
            (size**2, f"torque and position on the arm side of the gear (ratio {size:g})"),
        ]
    return known
