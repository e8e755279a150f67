"""Inertias of rotors that a robot file leaves out: those that torques show, and those that friction needs in steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.prediction.integration_step import least_inertia, stops_too_fast, substeps
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.gap.fit.torques.solution import TorqueRegression
    from flexros.gap.settings import TorqueStartSettings
    from flexros.robot import Robot

STEPS = 16
"""Steps per sample that the friction of motors without rotors may need [1] (chosen). Some URDFs have the same large
damping at every joint, which only keeps a simulator calm; a light wrist without rotor would stop within 0.1 ms."""


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


def inertias_to_step(
    robot: Robot, sample_time: float, of_bodies: Mapping[str, float], shows: float
) -> dict[str, float]:
    """Return the least inertias of motors without rotor with which their friction, or servos, can be stepped.

    Args:
        robot: The robot, driven as in the log.
        sample_time: Time between two samples [s].
        of_bodies: Inertia of the bodies that each of these motors moves, by name [kg m2 or kg].
        shows: Inertia over that of the bodies from which it is given [1].
    """
    if not stops_too_fast(robot, sample_time, STEPS):
        return {}
    kinds = ("viscous_friction", f"{SERVO}damping") if robot.commands == "position" else ("viscous_friction",)
    braking = {name: sum(robot.parameters[f"{name}.{kind}"].value for kind in kinds) for name in of_bodies}
    least = {name: least_inertia(value, sample_time, STEPS) for name, value in braking.items()}
    return {name: value for name, value in least.items() if value > shows * of_bodies[name]}


def inertias_for_friction(
    robot: Robot, sample_time: float, friction: Mapping[str, float], carried: Mapping[str, float]
) -> dict[str, float]:
    """Return the least inertias of motors without rotor with which the friction that their torques show can be stepped.

    Without it a light wrist with the friction of its gear would diverge in the steps of the nominal robot, and with it
    all that the torques of the other motors show.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        friction: Viscous friction by motor [Nm s/rad or N s/m].
        carried: Inertia by motor that is known [kg m2 or kg].
    """
    steps = substeps(robot, sample_time)
    least = {name: least_inertia(value, sample_time, steps) for name, value in friction.items()}
    return {name: value for name, value in least.items() if value > carried[name]}
