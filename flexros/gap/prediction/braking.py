"""Joints that friction stops faster than a simulation takes steps, as where a light wrist lacks its rotor."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.prediction.integration_step import stops_too_fast

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.robot import Robot


def braked_robot(model: RobotWithEffects) -> Robot:
    """Return the robot of a model with the viscous friction of its laws, the larger one of both directions.

    Args:
        model: The model.
    """
    robot = model.robot
    for law in model.laws:
        if isinstance(law.effect, ViscousFriction):
            (name,) = law.effect.numbers(robot, law.location)
            mean = robot.parameters[name].value + law.effect.coefficient
            robot = robot.with_values({name: max(0.0, mean) * (1 + abs(law.effect.asymmetry) / 2)})
    return robot


def runaway_warning(model: RobotWithEffects, sample_time: float, steps: int) -> tuple[str, ...]:
    """Name the motors whose viscous friction stops them faster than predictions take steps; empty without any.

    Args:
        model: The model.
        sample_time: Time between two samples of the log [s].
        steps: Integration steps per sample.
    """
    braked = braked_robot(model)
    if not stops_too_fast(braked, sample_time, steps):
        return ()
    names = {motor: f"{motor}.viscous_friction" for motor in braked.joint_names}
    calm = model.robot.with_values(dict.fromkeys(names.values(), 0.0))
    motors = [
        motor
        for motor, name in names.items()
        if stops_too_fast(calm.with_values({name: braked.parameters[name].value}), sample_time, steps)
    ]
    if not motors or stops_too_fast(calm, sample_time, steps):
        return ()
    return (
        f"viscous friction at {', '.join(motors)} stops light joints faster than predictions take steps "
        f"({sample_time / steps:.2g} s), so these may run away: a rotor inertia is missing there, or something else "
        "hides behind the friction",
    )
