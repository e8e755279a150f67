"""What happens between the integration steps of a plant: dry friction, bristles, lags, slip.

Before a step: the torques of the motors behind saturation, gain and lag, then the friction torques of the step, from
the accelerations under those torques. All are held through it. After it: what remembers where the step ended.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import casadi as ca

from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.bristle_friction import bristle_step
from flexros.effects.kinds.dry_friction import AHEAD, FrictionLevels, mean_friction
from flexros.effects.kinds.gear_law import AbstractGearLaw
from flexros.effects.kinds.motor_law import AbstractMotorLaw

if TYPE_CHECKING:
    from flexros.effects.patching.placement import PlacedLaw
    from flexros.simulate.plant_symbols import PlantSymbols

SWEEPS = 8
"""Passes over frictions that act on each other, per step; each starts from the last (chosen)."""


def smooth_torque(plant: PlantSymbols, torque: ca.SX) -> ca.SX:
    """Add up the torques without jumps at the motors.

    Args:
        plant: Symbols of the plant.
        torque: Torques of the motors behind saturation, gain and lag, SX (M, 1).

    Returns:
        Added torques, SX (M, 1).
    """
    added = ca.SX.zeros(plant.robot.n_motors)
    for law, effect in plant.laws.torques:
        added[law.motor] += effect.added(plant.motor(law, torque), plant.values(law))
    return added


def own_rates(plant: PlantSymbols, torque: ca.SX) -> ca.SX:
    """Evaluate the derivatives of the own states of all laws; zero for those that are updated between the steps.

    Args:
        plant: Symbols of the plant.
        torque: Torques of the motors behind saturation, gain and lag, SX (M, 1).

    Returns:
        Derivatives, SX.
    """
    rates = ca.SX.zeros(plant.x.numel())
    for law in plant.laws.all:
        effect, values = law.effect, plant.values(law)
        smooth = slice(plant.place(law).start, plant.place(law).start + effect.smooth_states)
        if not effect.smooth_states:
            continue
        if isinstance(effect, AbstractMotorLaw):
            rates[smooth] = effect.rates(plant.motor(law, torque), values)
        elif isinstance(effect, AbstractGearLaw):
            rates[smooth] = effect.rates(plant.gear(law), values)
        elif isinstance(effect, AbstractArmLaw):
            rates[smooth] = effect.rates(plant.arm(law), values)
    return rates[plant.friction_end :]


def step_updates(plant: PlantSymbols) -> tuple[ca.Function | None, ca.Function | None]:
    """Make the updates before and after an integration step.

    Args:
        plant: Symbols of the plant.

    Returns:
        Functions (x, u, w, p, h) -> x, None where a plant needs none.
    """
    step = ca.SX.sym("h")
    before, after = ca.SX(plant.x), ca.SX(plant.x)
    _pass_commands(plant, before, step)
    for law, effect in plant.laws.gears:
        place = _stepwise(plant, law)
        before[place] = effect.before_step(plant.gear(law), plant.values(law), step)
        after[place] = effect.after_step(plant.gear(law), plant.values(law), step)
    _rub(plant, before, step)
    arguments = [plant.x, plant.u, plant.w, plant.p, step]

    def function(name: str, changed: ca.SX) -> ca.Function | None:
        if ca.is_equal(changed, plant.x):
            return None
        return ca.Function(name, arguments, [ca.densify(changed)], {"cse": True})

    return function("before_step", before), function("after_step", after)


def _stepwise(plant: PlantSymbols, law: PlacedLaw) -> slice:
    place = plant.place(law)
    return slice(place.start + law.effect.smooth_states, place.stop)


def _pass_commands(plant: PlantSymbols, x: ca.SX, step: ca.SX) -> None:
    """Lead the commands through saturation, gain and lag, and write the memory of these into x."""
    torque = ca.SX(plant.u)
    for law, effect in plant.laws.commands:
        motor, values = law.motor, plant.values(law)
        own = effect.before_step(torque[motor], plant.own(law), values, step)
        x[plant.place(law)] = own
        torque[motor] = effect.passed(torque[motor], own, values)


def _rub(plant: PlantSymbols, x: ca.SX, step: ca.SX) -> None:
    """Find the friction torques of all motors that can stick, which act on each other, and write them into x."""
    bristles = plant.laws.bristles
    if not plant.rubbing and not bristles:
        return
    motors = [*plant.rubbing, *[law.motor for law, _ in bristles]]
    held = [plant.place(law).stop - 1 for law, _ in bristles]
    nq = plant.model.n_coordinates
    friction = ca.vertcat(plant.friction, *[plant.x[place] for place in held])
    free, slope, mobility = _accelerations(plant, x, motors, step)
    middle = 0.5 * step
    places = [plant.robot.motor_rows[motor] for motor in motors]
    speeds = [
        _within_direction(plant.v[place], plant.v[place] + middle * (free[k] - mobility[k, :] @ friction))
        for k, place in enumerate(places)
    ]
    for _ in range(1 if mobility.sparsity().is_diag() else SWEEPS):
        for k, motor in enumerate(motors):
            own = mobility[k, k]
            others = own * friction[k] - mobility[k, :] @ friction
            speed = plant.v[places[k]]
            if k < len(plant.rubbing):
                acceleration = free[k] + AHEAD * step * slope[k] + others
                friction[k] = mean_friction(speed, acceleration, own, _levels(plant, motor, speeds[k], middle), step)
                continue
            law, effect = bristles[k - len(plant.rubbing)]
            deflection = plant.place(law).start
            x[deflection], friction[k] = bristle_step(
                plant.x[deflection],
                speed,
                free[k] + middle * slope[k] + others,
                own,
                effect.bristle(speeds[k], plant.values(law)),
                step,
            )
    for place, torque in zip([*range(2 * nq, plant.friction_end), *held], ca.vertsplit(friction)):
        x[place] = torque


def _accelerations(plant: PlantSymbols, x: ca.SX, motors: list[int], step: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return accelerations without friction, what springs and own states add to them per time, and mobilities."""
    torque = ca.SX.sym("torque", plant.robot.n_motors)
    places = [plant.robot.motor_rows[motor] for motor in motors]
    free = motor_accelerations(plant, torque)[places]
    mobility = ca.jacobian(free, torque)[:, motors]
    passed = plant.torques(plant.u)
    free = ca.substitute(free, torque, passed + smooth_torque(plant, passed))
    own = plant.own_states
    if plant.laws.gears or plant.laws.arms:  # which may have corners, where a derivative would be a matter of rounding
        ahead = AHEAD * step
        moved = ca.vertcat(plant.q + ahead * plant.v, own + ahead * own_rates(plant, passed))
        slope = (ca.substitute(free, ca.vertcat(plant.q, own), moved) - free) / ahead
    else:
        slope = ca.jtimes(free, plant.q, plant.v)
        if own.numel():
            slope = slope + ca.jtimes(free, own, own_rates(plant, passed))
    if own.numel() and not ca.is_equal(x[plant.friction_end :], own):
        free, slope = (ca.substitute(one, own, x[plant.friction_end :]) for one in (free, slope))
    return free, slope, mobility


def motor_accelerations(plant: PlantSymbols, torque: ca.SX) -> ca.SX:
    """Evaluate the accelerations of all coordinates under motor torques, without friction that can stick.

    Args:
        plant: Symbols of the plant.
        torque: Torques at the motors, SX (M, 1).

    Returns:
        Accelerations, SX (n_coordinates, 1).
    """
    force = plant.added_force()
    state = (plant.q, plant.v, torque, plant.w)
    if force is None:
        return plant.model.acceleration(*state, plant.robot_parameters)
    return plant.model.forced_acceleration(*state, force, plant.robot_parameters)


def _within_direction(speed: ca.SX, later: ca.SX) -> ca.SX:
    """Return a speed that is expected later, but less by how fast the motor still turns the other way, down to zero.

    It is continuous, so that rounding of the speed of a motor at rest decides nothing.
    """
    beyond = ca.sign(later) * ca.fmax(ca.fabs(later) - ca.fabs(speed), 0)
    return ca.if_else(later * speed >= 0, later, beyond)


def _levels(plant: PlantSymbols, motor: int, speed: ca.SX, middle: ca.SX) -> FrictionLevels:
    """Add up the levels at a motor in the middle of a step, `middle` after its begin."""
    total, eased = FrictionLevels(ca.SX(0), ca.SX(0)), False
    for law, effect in plant.laws.frictions:
        if law.motor == motor:
            seen = replace(plant.motor(law, plant.u), speed=speed)
            if effect.smooth_states:
                rates = ca.vertcat(effect.rates(seen, plant.values(law)), ca.SX.zeros(effect.stepwise_states))
                seen = replace(seen, own=seen.own + middle * rates)
            total = total + effect.levels(seen, plant.values(law))
            eased = eased or effect.eases
    return FrictionLevels(ca.fmax(total.forward, 0), ca.fmax(total.backward, 0)) if eased else total
