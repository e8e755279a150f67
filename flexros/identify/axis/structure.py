"""Model structure of an axis: masses, gear law, friction; its parameters and equations of motion."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Literal

import casadi as ca
from pydantic import Field

from flexros.config.settings import Settings
from flexros.identify.axis.gear_law import PARAMETERS, GearLaw, gear_torque

if TYPE_CHECKING:
    from collections.abc import Mapping

OutputQuantity = Literal["position", "velocity"]
"""Measured quantity of the motor."""


class AxisStructure(Settings):
    """A motor, a gear and one or two arm masses in a row (thesis 4.2.2: the three-mass model is the usual one).

    The state is x = [q_m, d_1, ..., v_m, v_1, ...]: motor position, deflections of gear and arm spring, speeds of all
    masses. Where the speed is the output, q_m is omitted. Deflection d_1 is motor minus arm, d_2 first minus second
    arm mass. There is no gravity.
    """

    masses: Literal[2, 3] = Field(2, description="motor and one arm mass, or motor and two")
    gear: GearLaw = Field("piecewise", description="law of the gear stiffness")
    stribeck: bool = Field(False, description="whether the friction decreases with speed, by a Stribeck term")
    offset: bool = Field(False, description="whether a constant torque acts on the motor")
    output: OutputQuantity = Field("position", description="measured motor quantity that is predicted")
    rotary: bool = Field(True, description="whether the axis is rotary; it sets the units")

    @property
    def units(self) -> dict[str, str]:
        """Parameters by name with their units, in the order of theta."""
        rotary = {"motor_inertia": "kg m2", "arm_1_inertia": "kg m2", "gear_stiffness": "Nm/rad"}
        rotary |= {"gear_damping": "Nm s/rad", **PARAMETERS[self.gear]}
        if self.masses == 3:
            rotary |= {"arm_2_inertia": "kg m2", "arm_stiffness": "Nm/rad", "arm_damping": "Nm s/rad"}
        rotary |= {"viscous_friction": "Nm s/rad", "coulomb_friction": "Nm"}
        if self.stribeck:
            rotary |= {"stribeck_friction": "Nm", "stribeck_speed": "rad/s"}
        if self.offset:
            rotary |= {"offset": "Nm"}
        return rotary if self.rotary else {name: _sliding(unit) for name, unit in rotary.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, length P."""
        return tuple(self.units)

    @property
    def n_states(self) -> int:
        """Number of states."""
        return 2 * self.masses - 1 + (self.output == "position")

    @property
    def output_index(self) -> int:
        """Index of the output in the state."""
        return 0 if self.output == "position" else self.masses - 1

    @property
    def speed_index(self) -> int:
        """Index of the motor speed in the state."""
        return self.n_states - self.masses

    def derivative(self, smoothing: float) -> ca.Function:
        """Build the equations of motion.

        Coulomb and Stribeck friction cross zero speed as tanh(v / smoothing), so that sensitivities exist.

        Args:
            smoothing: Speed over which the friction changes sign [rad/s or m/s].

        Returns:
            CasADi function (x, u, theta) -> dx/dt.
        """
        x, u = ca.SX.sym("x", self.n_states), ca.SX.sym("u")
        theta = ca.SX.sym("theta", len(self.names))
        p = {name: theta[row] for row, name in enumerate(self.names)}
        speeds = ca.vertsplit(x[self.speed_index :])
        deflections = ca.vertsplit(x[self.speed_index - self.masses + 1 : self.speed_index])
        rates = [before - after for before, after in itertools.pairwise(speeds)]
        torques = [gear_torque(self.gear, deflections[0], p) + p["gear_damping"] * rates[0]]
        inertias = [p["motor_inertia"], p["arm_1_inertia"]]
        if self.masses == 3:
            torques.append(p["arm_stiffness"] * deflections[1] + p["arm_damping"] * rates[1])
            inertias.append(p["arm_2_inertia"])
        driving = [u - self._friction(speeds[0], p, smoothing), *torques]
        braking = [*torques, ca.SX(0)]
        accelerations = [(a - b) / inertia for a, b, inertia in zip(driving, braking, inertias)]
        position = [speeds[0]] if self.output == "position" else []
        return ca.Function("axis", [x, u, theta], [ca.vertcat(*position, *rates, *accelerations)], {"cse": True})

    def _friction(self, speed: ca.SX, p: Mapping[str, ca.SX], smoothing: float) -> ca.SX:
        level = p["coulomb_friction"]
        if self.stribeck:
            level = level + p["stribeck_friction"] * ca.exp(-((speed / p["stribeck_speed"]) ** 2))
        torque = p["viscous_friction"] * speed + level * ca.tanh(speed / smoothing)
        return torque - p["offset"] if self.offset else torque


def _sliding(unit: str) -> str:
    """Convert a rotary unit to the unit of a linear axis."""
    return {"kg m2": "kg", "Nm/rad": "N/m", "Nm s/rad": "N s/m", "Nm": "N", "rad": "m", "rad/s": "m/s"}.get(unit, unit)
