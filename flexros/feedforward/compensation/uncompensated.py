"""Report of the effects in a feedforward's model that it does not compensate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.delay import Delay
from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.bristle_friction import AbstractBristleFriction
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.gear_law import AbstractGearLaw
from flexros.effects.kinds.motor_law import AbstractMotorTorque
from flexros.effects.kinds.sensor import AbstractSensor
from flexros.effects.kinds.tool_error import AbstractToolError
from flexros.feedforward.base import feedforward_method
from flexros.feedforward.compensation.arm_forces import acts_at_once
from flexros.feedforward.compensation.encoder_reading import PERIODIC
from flexros.feedforward.compensation.motors import GAIN, LAG

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import PlacedLaw
    from flexros.feedforward.specification import FeedforwardSpecification
    from flexros.robot import Robot

COMPENSATED = (AbstractBristleFriction, AbstractDryFriction, AbstractMotorTorque, AbstractToolError)
"""Kinds of effects that are always compensated."""


def uncompensated(robot: Robot, laws: Sequence[PlacedLaw], specification: FeedforwardSpecification) -> tuple[str, ...]:
    """List the effects of its model that a feedforward does not compensate.

    Args:
        robot: The robot in the feedforward's model.
        laws: Laws of effects on it.
        specification: Method and its settings.

    Returns:
        One sentence for each such effect; none if the method is "none", which compensates nothing.
    """
    if specification.method == "none":
        return ()
    hold = specification.hold_compensation
    hold = feedforward_method(specification.method).compensates_hold(specification) if hold is None else hold
    reasons = {law.name: _reason(robot, law, hold) for law in laws if not law.effect.neutral}
    return tuple(
        f"the feedforward model has {name}, which is not compensated: {reason}"
        for name, reason in reasons.items()
        if reason
    )


def _reason(robot: Robot, law: PlacedLaw, hold: bool) -> str:
    """Return why a law is not compensated; empty if it is."""
    effect = law.effect
    if isinstance(effect, AbstractCommandLaw) and effect.filters_positions:
        return "it filters commanded positions, and a feedforward commands torques"
    if isinstance(effect, AbstractCommandLaw) and effect.rank not in (GAIN, LAG):
        return "no command exceeds a torque limit; slow the motion down"
    if isinstance(effect, Delay) and not hold:
        return "only hold_compensation anticipates it; set feedforward.hold_compensation to true"
    if isinstance(effect, AbstractSensor) and effect.rank != PERIODIC:
        return "the error of the encoder is not known in advance"
    if isinstance(effect, AbstractGearLaw):
        motors = [robot.joint_names[number] for number in robot.flexible_motors]
        gears = [robot.arm_names[robot.gear_rows[number]] for number in robot.flexible_motors]
        if law.location not in (*motors, *gears):
            return "it is in a spring without motor"
        return "the motors act on the arm in addition to their gears" if robot.spec.inertial_coupling else ""
    if isinstance(effect, AbstractArmLaw) and not acts_at_once(law):
        return "it has states of its own, which the inverse dynamics of the arm do not include"
    known = (*COMPENSATED, AbstractArmLaw, AbstractCommandLaw, AbstractSensor, Delay)
    return "" if isinstance(effect, known) else "the feedforward has no compensation for this kind of effect"
