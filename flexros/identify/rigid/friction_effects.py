"""Identified friction that a robot file cannot hold, as effects for a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.identify.rigid.fit import RigidFit

_SIGNIFICANT = 2.0
"""Deviations from zero above which a value is significant (chosen)."""

_LARGEST_ASYMMETRY = 2.0
"""Largest asymmetry that effects have: one direction without friction."""


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
    offset is half the difference of the directions.
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
        effect = _coulomb_effect(motor, values)
        if effect:
            effects.append(effect)
        pair = [excited.get(f"{motor}.viscous_friction_{direction}") for direction in ("forward", "backward")]
        if pair[0] is not None and pair[1] is not None:
            forward, backward = pair[0][0], pair[1][0]
            means.append(
                f"{motor}.viscous_friction in the robot file is the mean of {forward:.6g} forward and {backward:.6g} "
                "backward"
            )
    return FrictionOutsideFile(values, tuple(effects), tuple(means))


def _coulomb_effect(motor: str, values: Mapping[str, float]) -> str:
    """Effect of a motor; empty where its Coulomb friction was not identified or is not positive."""
    level, offset = values.get(f"{motor}.coulomb_friction", 0.0), values.get(f"{motor}.torque_offset", 0.0)
    forward, backward = (
        values.get(f"{motor}.coulomb_friction_{direction}", 0.0) for direction in ("forward", "backward")
    )
    if forward or backward:
        level, offset = (forward + backward) / 2, (forward - backward) / 2
    if level <= 0:
        return ""
    asymmetry = float(np.clip(2 * offset / level, -_LARGEST_ASYMMETRY, _LARGEST_ASYMMETRY))
    text = f"coulomb_friction@{motor}:level={level:.4g}"
    return f"{text},asymmetry={asymmetry:.3g}" if asymmetry else text
