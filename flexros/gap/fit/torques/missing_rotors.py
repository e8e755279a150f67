"""Rotors that a robot file leaves out, and friction in it that joints without rotors cannot have."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.gap.fit.torques.solution import TorqueRegression
    from flexros.gap.settings import TorqueStartSettings
    from flexros.robot import Robot

AT_ONCE = 4.0
"""Sample time over the time constant of a joint from which its friction stops it within a sample [1] (chosen)."""


def least_rotors(
    robot: Robot, of_bodies: Mapping[str, float], regression: TorqueRegression, settings: TorqueStartSettings
) -> dict[str, float]:
    """Return the inertias from which motors have rotors that a robot file lacks, by name [kg m2 or kg].

    What is large beside the bodies is no error of these. Less may be one, so that it must be clear beside all errors
    that the tolerance of the bodies allows for; else it would go into bodies, friction and counterbalance.

    Args:
        robot: The nominal robot.
        of_bodies: Inertia of the bodies that each motor moves, by name [kg m2 or kg].
        regression: The regression that shows the rotors.
        settings: Settings of the regressions.
    """
    clear = dict(zip(robot.joint_names, settings.clear_rotor * regression.inertia_deviation, strict=True))
    return {
        name: min(settings.least_rotor * bodies, max(clear[name], settings.least_clear_rotor * bodies))
        for name, bodies in of_bodies.items()
    }


def stops_at_once(robot: Robot, sample_time: float, of_bodies: Mapping[str, float]) -> bool:
    """Return whether the viscous friction of the robot file would stop a motor without rotor within a sample.

    Some URDFs have the same large damping at every joint, which only keeps a simulator calm.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        of_bodies: Inertia of the bodies that each of these motors moves, by name [kg m2 or kg].
    """
    friction = {name: robot.parameters[f"{name}.viscous_friction"].value for name in of_bodies}
    return any(value * sample_time > AT_ONCE * of_bodies[name] for name, value in friction.items())
