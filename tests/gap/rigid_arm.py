"""A rigid arm of two joints, without rotor inertias in its file, and logs of it that this program has not simulated."""

from __future__ import annotations

from functools import cache

import numpy as np
import yaml

from flexros.arrays import FloatArray
from flexros.record.record import Record
from flexros.robot import Robot, robot_from_data

T = 0.005
INERTIA, VISCOUS, COULOMB = np.array([0.8, 0.3]), np.array([4.0, 1.5]), np.array([6.0, 2.0])
ARM = """
name: arm
defaults: {source: chosen, tolerance: 0.05}
gravity: {value: [0, 0, -9.81], unit: m/s2, tolerance: 0.05}
bodies:
  - {mass: 6, center_of_mass: [0.2, 0, 0], inertia: {xx: 0.02, yy: 0.1, zz: 0.1}, length: [0.4, 0, 0],
     directions: {ry: {spring: rigid, damper: 0, motor: {inertia: 0}}}}
  - {mass: 3, center_of_mass: [0.15, 0, 0], inertia: {xx: 0.01, yy: 0.04, zz: 0.04}, length: [0.3, 0, 0],
     directions: {ry: {spring: rigid, damper: 0, motor: {inertia: 0}}}}
outputs: {tool: {pose: [x, z]}, joints: {coordinates: [body_1.ry, body_2.ry]}}
controlled: joints
"""


@cache
def arm() -> Robot:
    """Load a rigid arm whose file gives no rotor inertias."""
    return robot_from_data(yaml.safe_load(ARM), "arm.yaml")


def motion(seconds: float = 20.0) -> FloatArray:
    """Return positions, speeds and accelerations, shape (3, n, 2)."""
    time = T * np.arange(round(seconds / T))
    result = np.zeros((3, len(time), 2))
    for motor, lines in enumerate((((0.13, 0.5, 0.0), (0.31, 0.3, 1.0)), ((0.21, 0.6, 2.0), (0.47, 0.2, 0.5)))):
        for frequency, size, phase in lines:
            w = 2 * np.pi * frequency
            for order in range(3):
                result[order, :, motor] += size * w**order * np.sin(w * time + phase + order * np.pi / 2)
    return result


@cache
def record_of_arm(
    *,
    simulated: bool = False,
    imported: bool = False,
    seed: int = 5,
    asymmetry: float = 0.0,
    load: float = 0.0,
    balance: tuple[float, float] = (0.0, 0.0),
    cable: tuple[float, float] = (0.0, 0.0),
    share: float = 0.0,
    offset: float = 0.0,
    rotors: tuple[float, float] | None = None,
    rise: float = 0.0,
    seconds: float = 20.0,
) -> Record:
    """Compute the torques of that motion by inverse dynamics, with rotors and friction that the model lacks.

    Args:
        simulated: Whether this program has simulated it.
        imported: Whether it is of a real machine.
        seed: Of the encoder noise.
        asymmetry: Of the viscous friction of motor_1, (forward - backward) / mean.
        load: Mass and inertia of the last body beyond those of the model, relative to them.
        balance: Torques of a counterbalance at motor_1 at its positions 0 and 90 degrees [Nm].
        cable: Stiffness of a cable at motor_2 about its middle position [Nm/rad], and its cubic part [Nm/rad3].
        share: Friction of motor_1 per torque that its gear transmits [1].
        offset: Of the torque of motor_1 [Nm].
        rotors: Inertias of the rotors [kg m2]; None for `INERTIA`.
        rise: Speed within which the dry friction rises to its level [rad/s].
        seconds: Length [s].
    """
    q, v, a = motion(seconds)
    last = [name for name in arm().parameters if name.startswith(("body_2.mass", "body_2.inertia."))]
    model = arm().with_values({name: (1 + load) * arm().parameters[name].value for name in last}).model
    rigid = np.asarray(model.arm_inverse_dynamics(q.T, v.T, a.T, model.parameter_values), dtype=float).T
    uneven = 1 + 0.5 * np.array([asymmetry, 0.0]) * np.sign(v)
    torque = rigid + (INERTIA if rotors is None else np.array(rotors)) * a + VISCOUS * v * uneven
    torque += COULOMB * (np.tanh(v / rise) if rise else np.sign(v))
    torque[:, 0] += share * np.abs(rigid[:, 0]) * np.sign(v[:, 0])
    torque[:, 0] += offset
    torque[:, 0] -= balance[0] * np.cos(q[:, 0]) + balance[1] * np.sin(q[:, 0])
    pulled = q[:, 1] - q[:, 1].mean()
    torque[:, 1] += cable[0] * pulled + cable[1] * pulled**3
    noise = 1e-6 * np.random.default_rng(seed).standard_normal(q.shape)
    held = 0.5 * (torque + np.vstack([torque[1:], torque[-1:]]))
    valid = np.ones(len(q), dtype=bool)
    return Record("log", T, q + noise, held, valid, measured_torque=True, simulated=simulated, imported=imported)
