"""Drives and encoders of blind plants: the path from controller to motor and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.validation.blind.plant.equations import Equations, InnerState

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

KNEE = 1e-3
"""Relative width over which a saturating drive bends into its limit (chosen)."""
LONGEST_HALF = 30.0
"""Half a tick over the time constant of a lag from which nothing of it is left [1]."""


def gain(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Torque per command off by a factor."""
    for motor in plant.motors(place):
        plant.torque[motor] *= 1 + p["relative"]


def bias(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Constant torque."""
    for motor in plant.motors(place):
        plant.torque[motor] += p["level"]


def ripple(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Cogging (`proportional` 0) or ripple of the torque (1), with a second harmonic of a tenth."""
    for motor in plant.motors(place):
        turn = p["order"] * plant.angle(motor) + p["phase"]
        wave = p["amplitude"] * (ca.sin(turn) + 0.1 * ca.sin(2 * turn))
        plant.torque[motor] += wave * ca.if_else(p["proportional"] > 0.5, plant.torque[motor], 1)


def saturation(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Limit with a rounded knee."""
    for motor in plant.motors(place):
        u, limit = plant.torque[motor], p["limit"]
        width = KNEE * limit

        def beyond(size: ca.SX, limit: ca.SX = limit, width: ca.SX = width) -> ca.SX:
            return (size - limit + ca.sqrt((size - limit) ** 2 + width**2)) / 2

        plant.torque[motor] = u - ca.sign(u) * (beyond(ca.fabs(u)) - beyond(ca.SX(0)))


def lag(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """First-order lag of the current loop, moved by its exact solution; its mean over a tick acts through the tick."""
    for motor in plant.motors(place):
        held, given = ca.SX.sym("lagged"), plant.torque[motor]
        update = given + (held - given) * ca.exp(-plant.step / p["time_constant"])
        plant.states.append(InnerState(held, update=update))
        half = ca.fmin(plant.tick / 2 / p["time_constant"], LONGEST_HALF)  # `held` is the torque in the middle
        plant.torque[motor] = given + (held - given) * ca.sinh(half) / half


def delay(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Later arrival of the command."""
    for motor in plant.motors(place):
        plant.delays[motor] += p["time"]


def quantization(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Steps of the encoder."""
    for motor in plant.motors(place):
        _read(plant, motor, lambda y: p["step"] * ca.floor(y / p["step"] + 0.5))


def eccentricity(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Error of the encoder that repeats with the turning of the rotor."""
    for motor in plant.motors(place):
        turn = p["order"] * plant.angle(motor) + p["phase"]
        _read(plant, motor, lambda y, turn=turn: y + p["amplitude"] * ca.sin(turn), first=True)


def _read(plant: Equations, motor: int, reading: Callable[..., ca.SX], first: bool = False) -> None:
    """Add an encoder reading; quantisation is last, since the error of an encoder acts before its counting."""
    readings = plant.readings.setdefault(motor, [])
    readings.insert(0 if first else len(readings), reading)
