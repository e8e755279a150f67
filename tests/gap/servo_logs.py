"""Logs of a joint under a servo, without torques, and its robot."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from flexros.effects import parse_effect, place_effects
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.robot import Robot, robot_from_data
from flexros.simulate.plant import Plant

T = 4e-3
NOISE = 1e-4
SERVO_EFFECTS = (
    *("servo_stiffness_error", "servo_damping_error", "servo_feedforward_error", "servo_integral"),
    *("servo_command_lag", "actuator_lag", "delay", "coulomb_friction", "viscous_friction"),
    *("motor_inertia_error", "torque_gain_error", "gravity_error"),
)
"""What a servo, its commands and its friction may lack: effects that stand for each other in logs of positions."""
ONE = ("motor_1",)


def servo_robot(
    feedforward: float = 0.0,
    *,
    servo: bool = True,
    limit: float = 30.0,
    integral: float = 0.0,
    mass: float = 1.5,
    tolerance: float = 0.0,
    known: bool = False,
) -> Robot:
    """A joint with a link under gravity; stiffness 60 Nm/rad, damping 2 Nm s/rad, both with a tolerance."""
    motor = {"inertia": 0.05, "viscous_friction": 0.3, "torque_limit": limit}
    if servo:
        stiffness, damping = ({"value": value, "tolerance": tolerance} for value in (60.0, 2.0))
        gains = {"stiffness": stiffness, "damping": damping, "feedforward": feedforward, "integral": integral}
        motor["servo"] = gains | {"known": known}  # type: ignore[assignment]
    link = {
        "mass": mass,
        "center_of_mass": [0, 0, 0.2],
        "inertia": {"yy": 0.02 * mass / 1.5},
        "directions": {"ry": {"spring": "rigid", "motor": motor}},
    }
    data = {
        "name": "servo_joint",
        "gravity": [0, 0, -9.81],
        "sample_time": T,
        "sensors": {"encoder_noise": NOISE},
        "bodies": [link],
        "outputs": {"joints": {"coordinates": ["body_1.ry"]}},
        "controlled": "joints",
    }
    return robot_from_data(data, "servo_joint.yaml")


def servo_arm(*, rotors: bool = True, upright: bool = False) -> Robot:
    """Two links under gravity, the second one a wrist; stiffness 60 and 20 Nm/rad, damping 2 and 0.5 Nm s/rad.

    Args:
        rotors: Whether it has the inertia of its rotors.
        upright: Whether its first joint turns about the vertical.
    """
    links = []
    axes, shown = (("rz", "ry"), ("xx", "yy", "zz")) if upright else (("ry", "ry"), ("yy",))
    numbers = (1.5, 0.05, 60.0, 2.0), (0.3, 0.02, 20.0, 0.5)
    for axis, (mass, inertia, stiffness, damping) in zip(axes, numbers, strict=True):
        servo = {"stiffness": stiffness, "damping": damping}
        motor = {"inertia": inertia if rotors else 0, "viscous_friction": 0.1, "torque_limit": 30.0, "servo": servo}
        links.append(
            {
                "mass": mass,
                "center_of_mass": [0, 0, 0.5 * mass / 1.5],
                "inertia": dict.fromkeys(shown, 0.02 * mass),
                "length": [0, 0, 0.3],
                "directions": {axis: {"spring": "rigid", "motor": motor}},
            }
        )
    data = {
        "name": "servo_arm",
        "gravity": [0, 0, -9.81],
        "sample_time": T,
        "sensors": {"encoder_noise": NOISE},
        "bodies": links,
        "outputs": {"joints": {"coordinates": [f"body_{k + 1}.{axis}" for k, axis in enumerate(axes)]}},
        "controlled": "joints",
    }
    return robot_from_data(data, "servo_arm.yaml")


def command(duration: float, seed: int = 0) -> np.ndarray:
    """Commanded positions that begin at rest, shape (n, 1)."""
    time = np.arange(round(duration / T)) * T
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, 4)
    tones = sum(
        size * np.sin(2 * np.pi * f * time + phase)
        for size, f, phase in zip((0.5, 0.3, 0.1, 0.02), (0.21, 0.53, 1.3, 4.1), phases)
    )
    return np.asarray(0.2 + np.clip((time - 0.5) / 1.0, 0, 1) * tones)[:, None]


@cache
def servo_log(
    *effects: str,
    feedforward: float = 0.0,
    duration: float = 8.0,
    seed: int = 0,
    noise: float = NOISE,
    robot: Callable[[], Robot] | None = None,
    mass: float = 1.5,
) -> Log:
    """A log of commanded and measured positions of a joint with effects, or of another robot."""
    nominal = (servo_robot(feedforward, mass=mass) if robot is None else robot()).commanded_by("position")
    placed = place_effects(nominal, [parse_effect(text, "test") for text in effects])
    names = nominal.joint_names
    wanted = np.hstack([command(duration, seed + 7 * k) for k in range(len(names))])
    rate = np.gradient(wanted, T, axis=0)
    stiffness = np.array([placed.robot.parameters[f"{name}.servo_stiffness"].value for name in names])
    start = placed.robot.equilibrium(motor_position=wanted[0])
    carried = placed.robot.parameters["motor_1.servo_integral"].value > 0
    for _ in range(0 if carried else 3):  # the servo gives way to gravity
        sag = placed.robot.holding_torque(start) / stiffness
        start = placed.robot.equilibrium(motor_position=wanted[0] - sag)
    plant = Plant(placed.robot, T, start, laws=placed.laws, torque=wanted[0], substeps=8)
    positions = np.empty_like(wanted)
    for k, row in enumerate(wanted):
        positions[k] = plant.measure()
        plant.advance(row, rate[k])
    positions += noise * np.random.default_rng([seed, 1]).normal(size=positions.shape)
    stamp = stamps_ns(len(wanted), T)
    return Log(JointSeries(stamp, names, position=positions), JointSeries(stamp, names, position=wanted))
