"""Identified friction that a robot file cannot hold, as effects for a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.rigid.fit import RigidFit

_SIGNIFICANT = 2.0
"""Deviations from zero above which a value is significant (chosen)."""

_LARGEST_ASYMMETRY = 2.0
"""Largest asymmetry that friction has: one direction without any. More is a constant torque beside it."""


@dataclass(frozen=True)
class FrictionOutsideFile:
    """Identified friction that is not part of the robot file.

    Attributes:
        values: Coulomb friction and offset by parameter name [Nm or N], where the log excites them.
        effects: Effects that represent them, as NAME@LOCATION:parameter=value.
        means: Viscous friction of the file that is the mean of two directions, one sentence each.
    """

    values: Mapping[str, float]
    effects: tuple[str, ...]
    means: tuple[str, ...]


def friction_outside_file(fit: RigidFit) -> FrictionOutsideFile:
    """Collect the identified friction that a robot file cannot hold.

    The effect `coulomb_friction` has a level F and an asymmetry a, so F (1 + a/2) forward and F (1 - a/2) backward: an
    offset is half the difference of the directions. One beyond the friction is a `torque_bias`.
    """
    excited = {
        name: (float(value), float(deviation))
        for index, (name, value, deviation) in enumerate(zip(fit.base.names, fit.values, fit.deviation, strict=True))
        if index in fit.excitation.shown
    }
    values = {
        name: value
        for name, (value, deviation) in excited.items()
        if ("coulomb" in name or name.endswith("torque_offset")) and abs(value) > _SIGNIFICANT * deviation
    }
    effects, means = [], []
    for motor in fit.robot.joint_names:
        effects += _dry_effects(motor, values)
        pair = [excited.get(f"{motor}.viscous_friction_{direction}") for direction in ("forward", "backward")]
        if pair[0] is not None and pair[1] is not None:
            forward, backward = pair[0][0], pair[1][0]
            means.append(
                f"{motor}.viscous_friction in the robot file is the mean of {forward:.6g} forward and {backward:.6g} "
                "backward"
            )
    return FrictionOutsideFile(values, tuple(effects), tuple(means))


def _dry_effects(motor: str, values: Mapping[str, float]) -> list[str]:
    """Effects of a motor; none where neither its Coulomb friction is positive nor a constant torque was identified."""
    level, offset = values.get(f"{motor}.coulomb_friction", 0.0), values.get(f"{motor}.torque_offset", 0.0)
    forward, backward = (
        values.get(f"{motor}.coulomb_friction_{direction}", 0.0) for direction in ("forward", "backward")
    )
    if forward or backward:
        level, offset = (forward + backward) / 2, (forward - backward) / 2
    effects = [f"coulomb_friction@{motor}:level={level:.4g}"] if level > 0 else []
    if abs(2 * offset) > _LARGEST_ASYMMETRY * abs(level):  # the motor holds against it, so that it is opposite
        effects.append(f"torque_bias@{motor}:level={-offset:.4g}")
    elif effects and offset:
        effects[0] += f",asymmetry={2 * offset / level:.3g}"
    return effects
