"""Logs of simulated axes for the tests of this room."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import parse_effect, place_effects
from flexros.identify.axis.record import axis_record
from flexros.logs.time_series import JointSeries, Log
from flexros.record.read import read_record
from flexros.robot import load_robot, robot_from_data
from flexros.simulate.disturbance import Noise
from flexros.simulate.plant import Plant

if TYPE_CHECKING:
    from flexros.identify.axis.record import AxisRecord
    from flexros.identify.axis.structure import OutputQuantity
    from flexros.robot import Robot

EFFECTS = (
    "nonlinear_stiffness@body_1.rz:relative=0.8,knee=0.003",
    "coulomb_friction@motor_1:level=20",
    "viscous_friction@motor_1:coefficient=15",
)
"""A gear that hardens by 80 % at 3 mrad, with friction."""

TRUTH = {
    "motor_inertia": 4.0,
    "arm_1_inertia": 6.0,
    "gear_stiffness": 6e4,
    "gear_damping": 30.0,
    "gear_stiffening": 1.8,
    "gear_knee": 0.003,
    "viscous_friction": 15.0,
    "coulomb_friction": 20.0,
}
"""Parameters of two_mass with these effects."""


def three_mass() -> Robot:
    """Return a motor with gear and two arm masses on one axis, all values as in the tests."""
    direction = {"spring": 6e4, "damper": 30, "motor": {"inertia": 4.0}}
    return robot_from_data(
        {
            "name": "three_mass",
            "sample_time": 1e-3,
            "sensors": {"encoder_noise": 1e-5},
            "bodies": [
                {"inertia": {"zz": 4.0}, "directions": {"rz": direction}},
                {"inertia": {"zz": 2.0}, "directions": {"rz": {"spring": 5e4, "damper": 20}}},
            ],
            "tool": {"position": [1, 0, 0]},
            "outputs": {"joints": {"coordinates": ["body_1.rz"]}},
            "controlled": "joints",
        },
        "test",
    )


def recorded_axis(
    effects: tuple[str, ...] = EFFECTS,
    *,
    robot: Robot | None = None,
    seed: int = 1,
    samples: int = 6000,
    torque_noise: float = 5.0,
    rms: float = 250.0,
) -> Log:
    """Move an axis by a random-phase multisine torque, held in place by a weak controller.

    Args:
        effects: Effects of the plant.
        robot: The axis; default: two_mass.
        seed: Seed of phases and noise.
        samples: Number of samples.
        torque_noise: Rms of a torque that the log does not hold [Nm].
        rms: Rms of the multisine [Nm].

    Returns:
        Log with position, speed by the simulation, and commanded torque.
    """
    robot = load_robot("two_mass") if robot is None else robot
    placed = place_effects(robot, [parse_effect(text, "test") for text in effects])
    T, time = robot.sample_time, robot.sample_time * np.arange(samples)
    frequency = np.arange(0.3, 60.0, 0.1)
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(frequency))
    excitation = np.zeros(samples)
    for f, p in zip(frequency, phase, strict=True):
        excitation += (3.0 if f < 3 else 1.0) * np.cos(2 * np.pi * f * time + p)
    excitation *= rms / np.std(excitation)
    noise = Noise(kind="noise", at="motor_1", rms=torque_noise, low_hz=0.0, high_hz=300.0)
    start = placed.robot.equilibrium()
    plant = Plant(placed.robot, T, start, seed=seed, noise=True, laws=placed.laws, disturbances=[noise], substeps=4)
    position, speed, command = np.zeros(samples), np.zeros(samples), np.zeros(samples)
    place = robot.motor_rows[0]
    for k in range(samples):
        position[k] = plant.measure()[0]
        speed[k] = plant.state[robot.n_coordinates + place]
        rate = (position[k] - position[k - 1]) / T if k else 0.0
        command[k] = excitation[k] - 300 * position[k] - 20 * rate
        plant.advance(command[k : k + 1])
    speed += 1e-4 * np.random.default_rng(seed + 1).standard_normal(samples)
    stamp = 1_000_000_000 + np.arange(samples) * round(1e9 * T)
    return Log(
        JointSeries(stamp, ("motor_1",), position=position[:, None], velocity=speed[:, None]),
        JointSeries(stamp, ("motor_1",), effort=command[:, None]),
    )


def axis_of(log: Log, output: OutputQuantity = "position", delay: float = 0.0) -> AxisRecord:
    """Signals of motor_1 of a log of one motor."""
    return axis_record(read_record(log, load_robot("two_mass"), name="it"), 0, output, delay)
