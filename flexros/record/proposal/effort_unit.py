"""What the effort of a bag is: a torque, or a current, by the torque that the model needs for the motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.proposal.effort_comparison import EffortComparison

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.record.record import Record
    from flexros.robot import Robot

CLEAR = 0.85
"""Partial correlation of effort and torque of the model from which they are compared [1] (chosen)."""
ENOUGH = 3
"""Fewest clear joints, all of them opposite, from which the others are opposite too [1] (chosen)."""
TORQUE = 2.7
"""Factor, either way, within which an effort is a torque (chosen): load and masses of a rough model explain it; the
torque constants of gears with motors are 5 to 15 Nm/A, so that currents are farther off."""
LIKE = 1.5
"""Factor within which an effort has a known unit (chosen)."""


@dataclass(frozen=True)
class EffortUnit:
    """The effort of a bag.

    Attributes:
        unit: "Nm", "mNm", "kNm", or "A" for a current or another unit that needs a scale.
        scale: Torque per unit of every motor [Nm/A], length M; empty for torques.
        signs: -1 where the effort is opposite to the torque of the motor, length M.
        compared: Effort over torque of the model by motor, where they are alike [1].
        level: Geometric mean of their sizes, weighted by the torque of the model [1]; NaN where none are alike.
        alone: Whether one joint of several shows another unit, which a spring or a load there may do as well.
    """

    unit: str
    scale: tuple[float, ...]
    signs: tuple[int, ...]
    compared: Mapping[str, float]
    level: float
    alone: bool = False


def effort_unit(record: Record, robot: Robot, *, current: bool = False) -> EffortUnit:
    """Compare the effort, read as a torque [Nm], with the inverse-dynamics torque of the model.

    The effort of every motor is regressed on the torque of the model, its speed and the sign of it, its acceleration
    and a constant, for friction and a rotor that the model lacks. The joints with the largest torque decide: what a
    rough model lacks, such as a load, multiplies the torque of light wrists.

    Args:
        record: The log, its torques those of the effort.
        robot: The model.
        current: Whether it is known to be a current, whatever its size.
    """
    compared = EffortComparison.of(record, robot).at()
    signs = tuple(-1 if each.correlation < -CLEAR else 1 for each in compared)
    clear = {k: each for k, each in enumerate(compared) if abs(each.correlation) > CLEAR}
    if not clear:
        return EffortUnit("Nm", (), signs, {}, float("nan"))
    if len(clear) >= ENOUGH and all(each.correlation < 0 for each in clear.values()):
        signs = (-1,) * robot.n_motors  # a recorder has one convention; light wrists alone do not show it
    names = {robot.joint_names[k]: each.factor for k, each in clear.items()}
    factors = {k: abs(each.factor) for k, each in clear.items()}
    level = float(np.exp(np.average(np.log(list(factors.values())), weights=[each.power for each in clear.values()])))
    is_torque = 1 / TORQUE < level < TORQUE
    alone = not is_torque and len(clear) == 1 < robot.n_motors - 1
    if (is_torque or alone) and not current:
        return EffortUnit("Nm", (), signs, names, level, alone)
    for unit, size in (("mNm", 1e3), ("kNm", 1e-3)):
        if 1 / LIKE < level / size < LIKE and not current:
            return EffortUnit(unit, (), signs, names, level)
    return EffortUnit("A", _scales(factors, level, robot), signs, names, level)


def _scales(factors: Mapping[int, float], level: float, robot: Robot) -> tuple[float, ...]:
    """Return the torque per unit of every motor: its own, that of motors with its limit, or that of all.

    A load that the model lacks is in the factors of light wrists, so its own counts only near that of all.
    """
    limits = [float(limit) for limit in robot.torque_limits]
    own = {k: factor for k, factor in factors.items() if 1 / TORQUE < factor / level < TORQUE}
    scales = []
    for k, limit in enumerate(limits):
        alike = [factor for other, factor in own.items() if limits[other] == limit and np.isfinite(limit)]
        factor = own.get(k) or (float(np.exp(np.mean(np.log(alike)))) if alike else level)
        scales.append(float(f"{1 / factor:.3g}"))
    return tuple(scales)
