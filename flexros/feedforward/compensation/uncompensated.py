"""What a feedforward knows of its robot but cannot make up for, in words."""

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

MADE_UP_FOR = (AbstractBristleFriction, AbstractDryFriction, AbstractMotorTorque, AbstractToolError)
"""Kinds of effects that are always made up for."""


def uncompensated(robot: Robot, laws: Sequence[PlacedLaw], specification: FeedforwardSpecification) -> tuple[str, ...]:
    """Say which effects of its model a feedforward does not make up for.

    Args:
        robot: The robot as the feedforward knows it.
        laws: Laws of effects on it.
        specification: Method and its settings.

    Returns:
        A sentence for each such effect; none where the method is "none", which makes up for nothing.
    """
    if specification.method == "none":
        return ()
    hold = specification.hold_compensation
    hold = feedforward_method(specification.method).compensates_hold(specification) if hold is None else hold
    reasons = {law.name: _reason(robot, law, hold) for law in laws if not law.effect.neutral}
    return tuple(
        f"the feedforward knows of {name} but does not make up for it: {reason}"
        for name, reason in reasons.items()
        if reason
    )


def _reason(robot: Robot, law: PlacedLaw, hold: bool) -> str:
    """Say why a law is not made up for; empty where it is."""
    effect = law.effect
    if isinstance(effect, AbstractCommandLaw) and effect.rank not in (GAIN, LAG):
        return "no command gets more torque through a limit; slow the motion down"
    if isinstance(effect, Delay) and not hold:
        return "it acts ahead of time with hold_compensation alone; set feedforward.hold_compensation to true"
    if isinstance(effect, AbstractSensor) and effect.rank != PERIODIC:
        return "what the encoder loses is not known ahead of time"
    if isinstance(effect, AbstractGearLaw):
        motors = [robot.joint_names[number] for number in robot.flexible_motors]
        gears = [robot.arm_names[robot.gear_rows[number]] for number in robot.flexible_motors]
        if law.location not in (*motors, *gears):
            return "it lies in a spring without motor"
        return "the motors act on the arm beside their gears" if robot.spec.inertial_coupling else ""
    if isinstance(effect, AbstractArmLaw) and not acts_at_once(law):
        return "it has a motion of its own, which inverse dynamics of the arm do not hold"
    known = (*MADE_UP_FOR, AbstractArmLaw, AbstractCommandLaw, AbstractSensor, Delay)
    return "" if isinstance(effect, known) else "the feedforward does not know this kind of effect"
