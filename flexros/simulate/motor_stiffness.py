"""Stiffness and damping with which servos, viscous friction and other torques hold the motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.simulate.plant_rates import smooth_torque

if TYPE_CHECKING:
    from flexros.simulate.plant_symbols import PlantSymbols


@dataclass(frozen=True)
class MotorStiffness:
    """What holds the motors, each on its own.

    Attributes:
        stiffness: K of servos and of torques over position [Nm/rad or N/m], SX (M, 1).
        damping: D of servos and of viscous friction [Nm s/rad or N s/m], SX (M, 1).
    """

    stiffness: ca.SX
    damping: ca.SX

    def inertia(self, time: ca.SX) -> ca.SX:
        """Return the additional inertias of a step that is implicit for some time [kg m2 or kg], SX (M, 1)."""
        return time * self.damping + time * time * self.stiffness


def motor_stiffness(plant: PlantSymbols, *, limited: bool = False) -> MotorStiffness:
    """Return the stiffness and damping of the motors.

    Args:
        plant: Symbols of the plant.
        limited: Whether a servo at its torque limit has none; else it keeps its own.
    """
    passed = plant.torques(plant.u, limited=limited)
    torque = passed + smooth_torque(plant, passed)
    rows = list(plant.robot.motor_rows)
    ones = ca.SX.ones(len(rows))
    nominal = [plant.robot_value(f"{motor}.viscous_friction") for motor in plant.robot.joint_names]
    by_position, by_speed = (-ca.jtimes(torque, symbols, ones) for symbols in (plant.q[rows], plant.v[rows]))
    return MotorStiffness(ca.fmax(by_position, 0), ca.fmax(by_speed + ca.vertcat(*nominal), 0))
