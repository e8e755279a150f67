"""Viscous friction that predictions may have beside that of the robot, which says how fast joints may stop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.friction.viscous_friction import ViscousFriction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.candidate import Candidate


LIKELY = 0.3
"""Share of the largest friction of its range that a candidate may come to [1] (chosen): with all of it, the torque of a
motor would go into friction where it is fastest."""


def most_friction(model: RobotWithEffects, candidates: Sequence[Candidate]) -> tuple[float, ...]:
    """Return the viscous friction of known laws and much of the range of candidates [Nm s/rad or N s/m], length M.

    Of friction that depends on the direction, the larger one counts.

    Args:
        model: Robot and laws of known effects.
        candidates: Effects in addition to these.
    """
    friction = dict.fromkeys(model.robot.joint_names, 0.0)
    for law in model.laws:
        if isinstance(law.effect, ViscousFriction):
            friction[law.location] += law.effect.coefficient * (1 + abs(law.effect.asymmetry) / 2)
    for one in candidates:
        if one.effect is ViscousFriction:
            friction[one.location] += LIKELY * sum(free.high for free in one.free if free.name == "coefficient")
    return tuple(friction.values())
