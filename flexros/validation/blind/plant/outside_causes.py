"""Causes outside the effects library, for which a diagnosis should report an unknown effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.validation.blind.plant.friction import dry

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.validation.blind.plant.equations import Equations


def position_dependent_friction(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Dry friction whose level varies with position."""
    for motor in plant.motors(place):
        way = plant.q[plant.place(motor)] / p["length"]
        dry(plant, motor, p["level"] * (1 + 0.9 * ca.sin(2 * np.pi * way + p["phase"])))


def quadratic_drag(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Drag that grows with the square of the speed, as of a fan or of gears that churn their oil."""
    for motor in plant.motors(place):
        speed = plant.v[plant.place(motor)]
        plant.add_torque(motor, -p["coefficient"] * speed * ca.fabs(speed))


def tool_pushes(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """External pushes on the last arm coordinate; their times are drawn with the log."""
    del place
    plant.added[plant.robot.n_arm - 1] += p["height"] * plant.push


def rotating_imbalance(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Spindle at the tool that runs up slowly: its force grows with the square of its speed."""
    del place
    speed = p["speed"] * (1 + p["run_up"] * plant.time / 40)
    turned = p["speed"] * (plant.time + p["run_up"] * plant.time**2 / 80)
    plant.added[plant.robot.n_arm - 1] += p["force"] * (speed / p["speed"]) ** 2 * ca.sin(2 * np.pi * turned)


def cable(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Cable that snaps tight beyond an angle of the motor and stiffens."""
    for motor in plant.motors(place):
        pulled = ca.fmax(plant.q[plant.place(motor)] - p["angle"], 0) / p["length"]
        plant.add_torque(motor, -p["torque"] * (pulled + pulled**2))


def varying_stiffness(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Stiffness of a gear that swings slowly in time."""
    for motor in plant.motors(place):
        joint = plant.robot.gear_rows[motor]
        swing = p["relative"] * ca.sin(2 * np.pi * p["frequency"] * plant.time + p["phase"])
        plant.add_spring_torque(joint, swing * plant.spring_torque(joint, plant.deflection(joint).angle))


def periodic_disturbance(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Torque of a fixed frequency in time, independent of the motion."""
    for motor in plant.motors(place):
        wave = ca.sin(2 * np.pi * p["frequency"] * plant.time + p["phase"])
        plant.add_torque(motor, p["amplitude"] * wave)


def lost_commands(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Commands that do not arrive, so that the one before stays; which ones is drawn with the log."""
    del plant, place, p
