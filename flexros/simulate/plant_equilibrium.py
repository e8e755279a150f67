"""Equilibria of a plant whose springs or arm have laws of effects."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.robot.equilibrium_search import EquilibriumSearch
from flexros.simulate.plant_rates import smooth_torque

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects.kinds.command_law import AbstractCommandLaw
    from flexros.effects.patching.placement import PlacedLaw
    from flexros.simulate.plant_symbols import PlantSymbols


class PlantEquilibriumSearch(EquilibriumSearch):
    """Newton search for the equilibrium of gravity, springs and laws of effects, with the motors held.

    Args:
        plant: Symbols of the plant; its free parameters are arguments of each search.
        names: Names of the free parameters.
    """

    def __init__(self, plant: PlantSymbols, names: tuple[str, ...]) -> None:
        super().__init__(plant.model)
        self._parameter_names = names
        nq, model = plant.model.n_coordinates, plant.model
        still = np.zeros(model.n_motors)
        force = model.force(plant.q, np.zeros(nq), still, np.zeros(6), plant.robot_parameters)
        added = plant.added_force()
        if added is not None:
            own = own_at_rest(plant, ca.SX.zeros(model.n_motors))
            force = force + ca.substitute(
                added, ca.vertcat(plant.v, plant.own_states), ca.vertcat(ca.SX.zeros(nq), own)
            )
        q = ca.SX.sym("q", nq)
        force = ca.substitute(force, plant.q, q)
        slope = ca.densify(ca.jacobian(force[self._balanced], q)[:, self._free])
        self._force = ca.Function("rest", [q, plant.p], [ca.densify(force), slope])


def own_at_rest(plant: PlantSymbols, command: ca.SX) -> ca.SX:
    """Return the own states of all laws of a plant at rest.

    Args:
        plant: Symbols of the plant.
        command: Steady commands [Nm or N; of servos rad or m], SX (M, 1).

    Returns:
        Own states, SX, a function of q, p and the commands.
    """
    return ca.substitute(own_at_start(plant, command), plant.v, ca.SX.zeros(plant.v.numel()))


def own_at_start(plant: PlantSymbols, command: ca.SX) -> ca.SX:
    """Return the own states of all laws of a plant as at rest, except that masses attached to the arm move with it.

    Args:
        plant: Symbols of the plant.
        command: Steady commands [Nm or N; of servos rad or m], SX (M, 1).

    Returns:
        Own states, SX, a function of q, v, p and the commands.
    """
    x = ca.SX.zeros(plant.x.numel())

    def settled(signal: ca.SX, laws: Sequence[tuple[PlacedLaw, AbstractCommandLaw]]) -> ca.SX:
        for law, effect in laws:
            motor, values = law.motor, plant.values(law)
            own = effect.rest(signal[motor], values)
            x[plant.rows(law)] = own
            signal[motor] = effect.passed(signal[motor], own, values)
        return signal

    settled(plant.driven(settled(ca.SX(command), plant.laws.position_filters)), plant.laws.commands)
    for law, gear_effect in plant.laws.gears:
        own = gear_effect.rest(plant.gear(law), plant.values(law))
        x[plant.rows(law)] = ca.substitute(own, plant.own_states, x[plant.own_rows])
    x = ca.substitute(x, plant.v, ca.SX.zeros(plant.v.numel()))
    for law, arm_effect in plant.laws.arms:
        x[plant.rows(law)] = arm_effect.rest(plant.arm(law), plant.values(law))
    return x[plant.own_rows]


def torque_beyond_command(plant: PlantSymbols) -> ca.Function:
    """Build the function (x, u, p) -> motor torque at rest in excess of the commands, and its slope over the commands.

    The laws are linear in the torque, except for a saturation, which is linear where it is not reached.
    """
    passed = plant.torques(plant.u)
    beyond = (passed - plant.u) + smooth_torque(plant, passed)
    if plant.own_states.numel():
        beyond = ca.substitute(beyond, plant.own_states, own_at_rest(plant, plant.u))
    slope = ca.densify(ca.jacobian(beyond, plant.u))
    return ca.Function("beyond", [plant.x, plant.u, plant.p], [ca.densify(beyond), slope], {"allow_free": False})
