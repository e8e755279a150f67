"""Torques at the motors of a plant, and the rates of its state under them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.gear_law import AbstractGearLaw
from flexros.effects.kinds.motor_law import AbstractMotorLaw

if TYPE_CHECKING:
    from flexros.simulate.plant_symbols import PlantSymbols


def smooth_torque(plant: PlantSymbols, torque: ca.SX) -> ca.SX:
    """Sum the continuous torques of laws at the motors, SX (M, 1).

    Args:
        plant: Symbols of the plant.
        torque: Motor torques after saturation, gain and lag [Nm or N], SX (M, 1).
    """
    added = ca.SX.zeros(plant.robot.n_motors)
    for law, effect in plant.laws.torques:
        added[law.motor] += effect.added(plant.motor(law, torque), plant.values(law))
    return added


def own_rates(plant: PlantSymbols, torque: ca.SX) -> ca.SX:
    """Return the derivatives of the own states of all laws; zero for those updated between the steps.

    Args:
        plant: Symbols of the plant.
        torque: Motor torques after saturation, gain and lag [Nm or N], SX (M, 1).
    """
    rates = ca.SX.zeros(plant.x.numel())
    for law in plant.laws.all:
        effect, values = law.effect, plant.values(law)
        smooth = slice(plant.rows(law).start, plant.rows(law).start + effect.smooth_states)
        if not effect.smooth_states:
            continue
        if isinstance(effect, AbstractMotorLaw):
            rates[smooth] = effect.rates(plant.motor(law, torque), values)
        elif isinstance(effect, AbstractGearLaw):
            rates[smooth] = effect.rates(plant.gear(law), values)
        elif isinstance(effect, AbstractArmLaw):
            rates[smooth] = effect.rates(plant.arm(law), values)
    return rates[plant.own_rows]


def acting_torque(plant: PlantSymbols, *, limited: bool = True) -> ca.SX:
    """Return the torques of all motors with what their laws add, less the friction held in a step, SX (M, 1).

    Args:
        plant: Symbols of the plant.
        limited: Whether servos keep to the torque limits of the robot file.
    """
    passed = plant.torques(plant.u, limited=limited)
    torque = passed + smooth_torque(plant, passed)
    for row, motor in enumerate(plant.sticking_motors):
        torque[motor] -= plant.friction[row]
    for law, _ in plant.laws.bristles:
        torque[law.motor] -= plant.own(law)[-1]
    return torque


def rates_beside_motion(plant: PlantSymbols) -> ca.SX:
    """Return the derivatives of the states behind coordinates and their rates: friction, laws, servos, held input."""
    still = ca.SX.zeros(len(plant.sticking_motors))
    held = ca.SX.zeros(plant.input_rows.stop - plant.input_rows.start)
    own = own_rates(plant, plant.torques(plant.u))
    led = ca.SX.zeros(len(plant.leading))
    return ca.vertcat(still, own, plant.integral_rates(plant.followed(plant.u)), led, held)


def dynamics(plant: PlantSymbols, torque: ca.SX) -> tuple[ca.Function, list[ca.SX]]:
    """Return the function of the accelerations of all coordinates, without dry friction, and its inputs.

    Args:
        plant: Symbols of the plant.
        torque: Motor torques [Nm or N], SX (M, 1).
    """
    force = plant.added_force()
    state = [plant.q, plant.v, torque, plant.w]
    if force is None:
        return plant.model.acceleration, [*state, plant.robot_parameters]
    return plant.model.forced_acceleration, [*state, force, plant.robot_parameters]
