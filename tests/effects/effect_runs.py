"""Short runs of a robot with effects, and laws of gears taken alone, for the tests of effects."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from flexros.arrays import FloatArray
from flexros.effects import PlacedLaw, parse_effect, place_effects
from flexros.effects.kinds.gear_law import AbstractGearLaw, GearState
from flexros.robot import Robot
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel

Torque = Callable[[float], FloatArray]


def laws_of(robot: Robot, *texts: str) -> tuple[PlacedLaw, ...]:
    return place_effects(robot, [parse_effect(text, "test") for text in texts]).laws


def run(
    robot: Robot,
    laws: tuple[PlacedLaw, ...],
    samples: int,
    torque: Torque,
    start: FloatArray | None = None,
    substeps: int = 1,
) -> FloatArray:
    """Return the states [q, v] of all samples, shape (samples + 1, 2 nq); the torque is held through each."""
    state = np.zeros(2 * robot.n_coordinates) if start is None else start
    plant = Plant(robot, robot.sample_time, state, laws=laws, substeps=substeps)
    rows = [plant.state]
    for k in range(samples):
        plant.advance(torque(k * robot.sample_time))
        rows.append(plant.state)
    return np.array(rows)


def halving_errors(
    robot: Robot, laws: tuple[PlacedLaw, ...], samples: int, torque: Torque, start: FloatArray | None = None
) -> FloatArray:
    """Return the largest error of the coordinates with 1, 2, 4 and 8 steps per sample, against 64."""
    n = robot.n_coordinates
    exact = run(robot, laws, samples, torque, start, 64)[:, :n]
    errors = [np.max(np.abs(run(robot, laws, samples, torque, start, m)[:, :n] - exact)) for m in (1, 2, 4, 8)]
    return np.array(errors)


def still(robot: Robot) -> Torque:
    return lambda time: np.zeros(robot.n_motors)


def jacobian(model: PlantModel, size: int | None = None) -> FloatArray:
    """Return the slope of the derivative of a plant over its state, at zero."""
    n = model.n_states if size is None else size
    x = ca.SX.sym("x", model.n_states)
    rate = model.derivative(x, np.zeros(model.robot.n_motors), np.zeros(6), np.zeros(len(model.parameter_names)))
    slope: FloatArray = ca.Function("slope", [x], [ca.densify(ca.jacobian(rate, x))])(np.zeros(model.n_states)).full()
    return slope[:n, :n]


class GearLaw:
    """A law of a gear with the spring torque f(d) = stiffness d + cubic d^3, taken alone.

    Args:
        effect: The law.
        stiffness: Of the spring.
        damping: Of the damper.
        cubic: Of the spring.
        turns: Rotor angle per motor coordinate.
    """

    def __init__(
        self, effect: AbstractGearLaw, stiffness: float, damping: float = 0.0, cubic: float = 0.0, turns: float = 1.0
    ) -> None:
        d, rate, angle, speed, step = (ca.SX.sym(name) for name in ("d", "rate", "angle", "speed", "step"))
        own = ca.SX.sym("own", effect.n_states)

        def spring(deflection: ca.SX) -> ca.SX:
            return stiffness * deflection + cubic * deflection**3

        nominal = spring(d) + damping * rate
        gear = GearState(d, rate, angle, speed, turns, nominal, damping, spring, own)
        added = effect.added(gear, effect.parameter_values)
        arguments = [d, rate, angle, speed, own]
        self._torques = ca.Function("torques", arguments, [nominal + added.arm, -nominal + added.motor])
        self._after = ca.Function("after", [*arguments, step], [effect.after_step(gear, effect.parameter_values, step)])
        self._rest = ca.Function("rest", [d, angle], [effect.rest(gear, effect.parameter_values)])

    def start(self, deflection: float, angle: float = 0.0) -> FloatArray:
        own: FloatArray = self._rest(deflection, angle).full().ravel()
        return own

    def torques(
        self, deflection: float, own: FloatArray, rate: float = 0.0, angle: float = 0.0, speed: float = 0.0
    ) -> tuple[float, float]:
        """Return the torques on arm and motor, nominal ones included."""
        arm, motor = self._torques(deflection, rate, angle, speed, own)
        return float(arm), float(motor)

    def after(self, deflection: float, own: FloatArray, step: float, rate: float = 0.0) -> FloatArray:
        states: FloatArray = self._after(deflection, rate, 0.0, 0.0, own, step).full().ravel()
        return states

    def along(self, path: FloatArray) -> FloatArray:
        """Return the torque on the arm along a path of deflections that begins at its first point, at rest."""
        own = self.start(0.0)
        torques = []
        for deflection in path:
            torques.append(self.torques(deflection, own)[0])
            own = self.after(deflection, own, 1e-3)
        return np.array(torques)
