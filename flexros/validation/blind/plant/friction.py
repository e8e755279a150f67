"""Friction of blind plants: bristles, whereas the effects library solves for the instants of sticking.

Dry friction is an elasto-plastic bristle so stiff that it bends by a tenth of the encoder noise before it slips; its
deflection is moved exactly under the speed of a half step. Speed dependence follows Hess and Soom (1990),
1 / (1 + (v / v_s)^2), where the library has a Gaussian.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.validation.blind.plant.equations import Equations, InnerState

if TYPE_CHECKING:
    from collections.abc import Mapping

BEND = 0.1
"""Largest deflection of the stiff bristle over the encoder noise (chosen)."""
BRISTLE_DAMPING = 0.7
"""Damping ratio of a motor that sticks to the stiff bristle (chosen)."""


def hump(speed: ca.SX, width: ca.SX) -> ca.SX:
    """Evaluate the hump of friction at low speed, 1 at standstill (Hess and Soom 1990)."""
    return 1 / (1 + (speed / width) ** 2)


def dry(plant: Equations, motor: int, level: ca.SX, asymmetry: ca.SX | float = 0.0) -> None:
    """Add a dry friction.

    Args:
        plant: The plant.
        motor: Number of the motor.
        level: Mean level of both directions [Nm or N]; may depend on state and time.
        asymmetry: (forward - backward) / mean [1].
    """
    place = plant.place(motor)
    speed = plant.v[place]
    bend = BEND * float(plant.robot.encoder_noise[motor])
    share = ca.SX.sym("bristle")
    plant.states.append(InnerState(share, update=ca.fmin(ca.fmax(share + speed * plant.step / bend, -1), 1)))
    inertia = plant.robot.motors[motor].inertia
    damping = 2 * BRISTLE_DAMPING * ca.sqrt(ca.fabs(level) * inertia / bend) * (1 - share**2)
    plant.add_torque(motor, -level * (share + asymmetry / 2 * ca.fabs(share)) - damping * speed)


def viscous(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Viscous friction; `asymmetry` is the relative difference of the two directions."""
    for motor in plant.motors(place):
        v = plant.v[plant.place(motor)]
        plant.add_torque(motor, -p["coefficient"] * (v + p["asymmetry"] / 2 * ca.fabs(v)))


def coulomb(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Dry friction of constant level."""
    for motor in plant.motors(place):
        dry(plant, motor, p["level"], p["asymmetry"])


def stribeck(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Only the hump of dry friction at low speed."""
    for motor in plant.motors(place):
        dry(plant, motor, p["extra"] * hump(plant.v[plant.place(motor)], p["velocity"]))


def presliding(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """LuGre friction (Canudas de Wit et al. 1995), moved by its exact solution under constant speed."""
    for motor in plant.motors(place):
        v, z = plant.v[plant.place(motor)], ca.SX.sym("z")
        limit = (p["level"] + p["extra"] * hump(v, p["velocity"])) / p["stiffness"]
        end = ca.sign(v) * limit
        update = end + (z - end) * ca.exp(-ca.fabs(v) * plant.step / limit)
        plant.states.append(InnerState(z, update=update))
        rate = v - ca.fabs(v) * z / limit
        plant.add_torque(motor, -p["stiffness"] * z - p["damping"] * rate)


def drift(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Friction that grows from nothing to a Coulomb level and a viscous coefficient at the end of the log."""
    grown = (1 - ca.exp(-plant.time / p["time_constant"])) / (1 - ca.exp(-p["duration"] / p["time_constant"]))
    grown = ca.fmax(grown, 0)
    for motor in plant.motors(place):
        plant.add_torque(motor, -p["viscous"] * grown * plant.v[plant.place(motor)])
        dry(plant, motor, p["coulomb"] * grown)


def loaded(plant: Equations, place: str, p: Mapping[str, ca.SX]) -> None:
    """Dry friction in proportion to the torque of the gear, rounded below the torque `least`, unlike in the library."""
    for motor in plant.motors(place):
        joint = plant.robot.gear_rows[motor]
        load = plant.gear_torque(joint, plant.twist(motor))
        dry(plant, motor, p["share"] * ca.sqrt(load**2 + p["least"] ** 2))
