"""Updates of a plant between its integration steps: dry friction, bristles, lags, slip.

Before a step: the motor torques after saturation, gain and lag, then the friction torques of the step from the
accelerations under those torques. All are held through the step. After it: states with memory of its end.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.nested_calls import is_long
from flexros.effects.kinds.bristle_friction import bristle_step
from flexros.effects.kinds.dry_friction import AHEAD, FrictionLevels, mean_friction, way_beside_mean
from flexros.simulate.motor_stiffness import motor_stiffness
from flexros.simulate.plant_rates import dynamics, own_rates, smooth_torque
from flexros.simulate.stages import Stages

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects.kinds.command_law import AbstractCommandLaw
    from flexros.effects.patching.placement import PlacedLaw
    from flexros.simulate.plant_symbols import PlantSymbols

SWEEPS = 8
"""Sweeps over coupled friction torques per step, warm-started from the last step (chosen)."""


def step_updates(
    plant: PlantSymbols, *, implicit: bool = False, placed: bool = False
) -> tuple[ca.Function | None, ca.Function | None]:
    """Build the updates (x, u, w, p, h) -> x before and after an integration step; None where not needed.

    Args:
        plant: Symbols of the plant.
        implicit: Whether the step is the one of `implicit_step`.
        placed: Whether dry friction that jumps within a step also moves the motors by what that adds to its mean.
    """
    step = ca.SX.sym("h")
    before, after = ca.SX(plant.x), ca.SX(plant.x)
    _update_command_laws(plant, before, step)
    for law, effect in plant.laws.gears:
        rows = _stepwise(plant, law)
        before[rows] = effect.before_step(plant.gear(law), plant.values(law), step)
        after[rows] = effect.after_step(plant.gear(law), plant.values(law), step)
    if plant.leading:
        after[plant.led_rows] = plant.without_lead(plant.followed(plant.u), step)
    arguments = [plant.x, plant.u, plant.w, plant.p, step]
    stages = Stages(arguments)
    _update_friction(plant, before, step, stages, implicit=implicit, placed=placed)
    if plant.input_rows.stop > plant.input_rows.start:
        before[plant.input_rows] = ca.vertcat(plant.u, plant.w)

    def function(name: str, changed: ca.SX, stages: Stages) -> ca.Function | None:
        return None if ca.is_equal(changed, plant.x) else stages.function(name, changed)

    return function("before_step", before, stages), function("after_step", after, Stages(arguments))


def _stepwise(plant: PlantSymbols, law: PlacedLaw) -> slice:
    rows = plant.rows(law)
    return slice(rows.start + law.effect.smooth_states, rows.stop)


def _update_command_laws(plant: PlantSymbols, x: ca.SX, step: ca.SX) -> None:
    """Write the own states of filters, saturation, gain and lag under the commands into x."""

    def updated(signal: ca.SX, laws: Sequence[tuple[PlacedLaw, AbstractCommandLaw]]) -> ca.SX:
        for law, effect in laws:
            motor, values = law.motor, plant.values(law)
            own = effect.before_step(signal[motor], plant.own(law), values, step)
            x[plant.rows(law)] = own
            signal[motor] = effect.passed(signal[motor], own, values)
        return signal

    filters = plant.laws.position_filters if plant.robot.commands == "position" else []
    updated(plant.driven(updated(ca.SX(plant.u), filters)), plant.laws.commands)


def _update_friction(
    plant: PlantSymbols, x: ca.SX, step: ca.SX, stages: Stages, *, implicit: bool, placed: bool
) -> None:
    """Solve for the coupled friction torques of all motors by Gauss-Seidel sweeps, and write them into x."""
    bristles = plant.laws.bristles
    if not plant.sticking_motors and not bristles:
        return
    motors = [*plant.sticking_motors, *[law.motor for law, _ in bristles]]
    loaded = {law.motor for law, effect in plant.laws.frictions if effect.needs_load}
    held = [plant.rows(law).stop - 1 for law, _ in bristles]
    nq = plant.model.n_coordinates
    friction = ca.vertcat(plant.friction, *[plant.x[row] for row in held])
    rows = [plant.robot.motor_rows[motor] for motor in motors]
    motion = _implicit_motion if implicit else _explicit_motion
    found = motion(plant, x, motors, step, stages)
    free, slope, mobility = found.free[rows], found.slope, found.mobility[rows, :]
    middle = 0.5 * step
    speeds = [
        _within_direction(plant.v[row], plant.v[row] + middle * (free[k] - mobility[k, :] @ friction))
        for k, row in enumerate(rows)
    ]

    def load(k: int, motor: int) -> ca.SX:
        """Return the torque that a gear transmits in the middle of the step, under the friction found so far."""
        if motor in plant.robot.flexible_motors:
            return _gear_load(plant, x, motor, found.free, dict(zip(rows, speeds, strict=True)), middle)
        mean = free[k] + middle * slope[k] - mobility[k, :] @ friction
        braked = found.torque[motor] - sum(friction[j] for j, other in enumerate(motors) if other == motor)
        return braked - _own_torque(plant, motor, speeds[k], mean)

    ways, means = {}, dict[int, ca.SX]()
    coupled = not mobility.sparsity().is_diag() or bool(loaded & set(plant.robot.stiff_motors))
    for _ in range(SWEEPS if coupled else 1):
        for k, motor in enumerate(motors):
            own = mobility[k, k]
            others = own * friction[k] - mobility[k, :] @ friction
            speed = plant.v[rows[k]]
            if k < len(plant.sticking_motors):
                acceleration = free[k] + AHEAD * step * slope[k] + others
                carried = load(k, motor) if motor in loaded else ca.SX(0)
                levels = _levels(plant, motor, speeds[k], middle, carried)
                friction[k] = mean_friction(speed, acceleration, own, levels, step)
                ways[k] = way_beside_mean(speed, acceleration, own, levels, step) / own
                continue
            law, effect = bristles[k - len(plant.sticking_motors)]
            deflection = plant.rows(law).start
            moved = bristle_step(
                plant.x[deflection],
                speed,
                free[k] + middle * slope[k] + others,
                own,
                effect.bristle(speeds[k], plant.values(law)),
                step,
                means.get(k),
            )
            x[deflection], friction[k], means[k] = moved.deflection, moved.torque, moved.mean
    for row, value in zip([*range(2 * nq, plant.friction_end), *held], ca.vertsplit(friction)):
        x[row] = value
    if placed:
        x[:nq] += sum(found.mobility[:, k] * way for k, way in ways.items())


def _own_torque(plant: PlantSymbols, motor: int, speed: ca.SX, acceleration: ca.SX) -> ca.SX:
    """Return the torque that accelerates a rotor against its nominal friction."""
    name = plant.robot.joint_names[motor]
    return plant.robot_value(f"{name}.inertia") * acceleration + plant.robot_value(f"{name}.viscous_friction") * speed


def _gear_load(
    plant: PlantSymbols, x: ca.SX, motor: int, acceleration: ca.SX, speeds: Mapping[int, ca.SX], middle: ca.SX
) -> ca.SX:
    """Return the torque of a flexible gear in the middle of a step.

    Args:
        plant: Symbols of the plant.
        x: State of the plant before the step, with its updated own states.
        motor: Index of the motor.
        acceleration: Accelerations of all coordinates without friction [rad/s2 or m/s2].
        speeds: Speeds of motors with friction in the middle of the step, by row [rad/s or m/s].
        middle: Half of the step [s].
    """
    speed = plant.v + middle * acceleration
    for row, value in speeds.items():
        speed[row] = value
    there = ca.vertcat(plant.q + middle * plant.v, speed, x[plant.own_rows])
    return ca.substitute(plant.gear_torque(motor), ca.vertcat(plant.q, plant.v, plant.own_states), there)


@dataclass(frozen=True)
class _FreeMotion:
    """Motion without friction at the start of a step.

    Attributes:
        free: Accelerations of all coordinates.
        slope: Their rates at the motors with friction, due to springs and own states.
        mobility: Accelerations of all coordinates per torque at each motor with friction.
        torque: Torques at all motors.
    """

    free: ca.SX
    slope: ca.SX
    mobility: ca.SX
    torque: ca.SX


def _implicit_motion(plant: PlantSymbols, x: ca.SX, motors: list[int], step: ca.SX, stages: Stages) -> _FreeMotion:
    """Return the motion without friction as a step sees it that is implicit in stiffness and damping of the motors.

    These see the way of the whole step, and what else changes within a step that short counts for nothing.
    """
    passed, own = plant.torques(plant.u), plant.own_states
    driven = passed + smooth_torque(plant, passed)
    stiffness = motor_stiffness(plant)
    shift = -step * stiffness.stiffness * plant.v[list(plant.robot.motor_rows)]
    force = plant.added_force()
    added = ca.SX.zeros(plant.model.n_coordinates) if force is None else force
    torque, laws = (ca.substitute(one, own, x[plant.own_rows]) if own.numel() else one for one in (driven, added))
    inertia = plant.of_motors(stiffness.inertia(step))
    inputs = [plant.q, plant.v, torque + shift, plant.w, laws, inertia, plant.robot_parameters]
    free, mobility = stages.call(plant.model.heavier_acceleration_with_mobility, *inputs)
    return _FreeMotion(free, ca.SX.zeros(len(motors)), mobility[:, motors], torque)


def _explicit_motion(plant: PlantSymbols, x: ca.SX, motors: list[int], step: ca.SX, stages: Stages) -> _FreeMotion:
    """Return the motion without friction."""
    rows = [plant.robot.motor_rows[motor] for motor in motors]
    passed, own = plant.torques(plant.u), plant.own_states
    ahead = AHEAD * step
    moved = ca.vertcat(plant.q + ahead * plant.v, own + ahead * own_rates(plant, passed))

    def updated(value: ca.SX) -> ca.SX:
        return ca.substitute(value, own, x[plant.own_rows]) if own.numel() else value

    driven = passed + smooth_torque(plant, passed)
    if plant.robot.is_rigid and is_long(plant.model.acceleration):
        force = plant.added_force()
        added = ca.SX.zeros(plant.model.n_coordinates) if force is None else force
        now = [plant.q, plant.v, driven, plant.w, added, plant.robot_parameters]
        later = [ca.substitute(value, ca.vertcat(plant.q, own), moved) for value in now]
        free, mobility = stages.call(plant.model.acceleration_with_mobility, *map(updated, now))
        then = stages.call(plant.model.forced_acceleration, *map(updated, later))[0]
        return _FreeMotion(free, (then[rows] - free[rows]) / ahead, mobility[:, motors], updated(driven))
    torque = ca.SX.sym("torque", plant.robot.n_motors)
    function, inputs = dynamics(plant, torque)
    free = function(*inputs)
    mobility = ca.jacobian(free, torque)[:, motors]
    free = ca.substitute(free, torque, driven)
    corners = plant.laws.gears or plant.laws.arms  # where a derivative would depend on round-off
    if corners or plant.robot.is_rigid:  # and that of a rigid arm is longer than the accelerations
        slope = (ca.substitute(free[rows], ca.vertcat(plant.q, own), moved) - free[rows]) / ahead
    else:
        slope = ca.jtimes(free[rows], plant.q, plant.v)
        if own.numel():
            slope = slope + ca.jtimes(free[rows], own, own_rates(plant, passed))
    return _FreeMotion(updated(free), updated(slope), mobility, updated(driven))


def _within_direction(speed: ca.SX, later: ca.SX) -> ca.SX:
    """Return the predicted speed, on a reversal reduced in magnitude by the present speed, down to zero.

    It is continuous, so that round-off in the speed of a motor at rest has no effect.
    """
    beyond = ca.sign(later) * ca.fmax(ca.fabs(later) - ca.fabs(speed), 0)
    return ca.if_else(later * speed >= 0, later, beyond)


def _levels(plant: PlantSymbols, motor: int, speed: ca.SX, middle: ca.SX, load: ca.SX) -> FrictionLevels:
    """Sum the levels at a motor in the middle of a step, `middle` after its start, under the load of its gear."""
    total, eased, kinds = FrictionLevels(ca.SX(0), ca.SX(0)), False, set()
    for law, effect in plant.laws.frictions:
        if law.motor == motor:
            seen = replace(plant.motor(law, plant.u), speed=speed, load=load)
            if effect.smooth_states:
                rates = ca.vertcat(effect.rates(seen, plant.values(law)), ca.SX.zeros(effect.stepwise_states))
                seen = replace(seen, own=seen.own + middle * rates)
            total = total + effect.levels(seen, plant.values(law))
            eased = eased or effect.eases or (effect.reduces and effect.name in kinds)
            kinds.add(effect.name)
    return FrictionLevels(ca.fmax(total.forward, 0), ca.fmax(total.backward, 0)) if eased else total
