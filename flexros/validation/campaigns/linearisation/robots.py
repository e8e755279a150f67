"""Robots of the study with motion and disturbances."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from flexros.robot import load_robot
from flexros.robot.robot import robot_from_data

if TYPE_CHECKING:
    from flexros.robot import Robot

ENCODER_NOISE = 2e-6
"""Noise of the encoders at motors and links, rms [rad]: that of the robot files."""

CALM, SECOND, CHIRP, END = 0.5, 2.0, 3.5, 6.0
"""Start of the force at the tool, of the torque at the motor and of the chirp at the tool, and the end [s] (chosen)."""


@dataclass(frozen=True)
class StudyRobot:
    """A robot of the study.

    Attributes:
        name: Name of the robot.
        trajectory: Trajectory of the tracking task, as in a scenario.
        output: Output that the trajectory moves; empty for the controlled one of the robot.
        poses: Arm coordinates of the tuning [rad], each of length N.
        force: Step of the force at the tool, along z [N].
        torque: Step of the torque at motor 1 [Nm].
        chirp: Amplitude of the chirp of the force at the tool, along z, 1 to 30 Hz [N].
        bandwidth: Bandwidth of all laws in the tuning of equal bandwidth [rad/s].
        torque_noise: Largest torque that the noise of the encoders may cause in the tuning of equal robustness, rms
            [Nm].
    """

    name: str
    trajectory: dict[str, Any]
    output: str
    poses: tuple[tuple[float, ...], ...]
    force: float = 200.0
    torque: float = 200.0
    chirp: float = 50.0
    bandwidth: float = 50.0
    torque_noise: float = 30.0

    def disturbances(self) -> list[dict[str, Any]]:
        """Return the disturbances of the regulation task, as in a scenario."""
        chirp = {"from_hz": 1.0, "to_hz": 30.0, "duration": END - CHIRP - 0.05}
        return [
            {"kind": "step", "at": "tool.fz", "start": CALM, "amplitude": self.force},
            {"kind": "step", "at": "motor_1", "start": SECOND, "amplitude": self.torque},
            {"kind": "chirp", "at": "tool.fz", "start": CHIRP, "amplitude": self.chirp, **chirp},
        ]


ELBOW = StudyRobot(
    "elbow",
    {
        "path": {
            "type": "joint_moves",
            "points_from_start": [[0.5, 0.2], [0.8, -0.6], [0.1, -0.4], [0.0, 0.0]],
            "zone": 0.15,
        },
        "time_law": {"type": "bang_bang_snap", "speed": 1.2, "acceleration": 3, "jerk": 40, "snap": 1000},
        "hold_before": 0.2,
        "hold_after": 0.5,
    },
    "joints",
    ((0.2, 0.3), (0.9, -0.4), (0.3, -0.1)),
)
"""Two links on elastic gears under gravity, and the joint moves of `elbow_moves`."""

E12 = StudyRobot(
    "e12",
    {
        "path": {"type": "circle", "centre_from_start": [-0.05, 0.0]},
        "time_law": {"type": "ninth_degree", "duration": 1.6},
        "hold_before": 0.2,
        "hold_after": 0.3,
    },
    "",
    ((0.0, 0.3, 0.0), (0.0, 1.0, 0.0), (0.0, 0.15, 0.0)),
    force=50.0,
    torque=100.0,
    bandwidth=8.0,
    torque_noise=60.0,
)
"""Two motors and an elastic tool that no motor drives (Paper B), on a circle of 50 mm radius."""

ROBOTS: tuple[StudyRobot, ...] = (ELBOW, E12)


@dataclass(frozen=True)
class Encoders:
    """Encoders of a study robot.

    Attributes:
        links: Whether the links have encoders.
        noise: Noise of all encoders, rms [rad].
    """

    links: bool = False
    noise: float = field(default=ENCODER_NOISE)


def robot_with(name: str, encoders: Encoders) -> Robot:
    """Return a robot whose tool is seen without noise, with the encoders of the study.

    Args:
        name: Name of the robot.
        encoders: Its encoders.
    """
    data = load_robot(name).spec.model_dump()
    noise = {"value": encoders.noise, "unit": "rad", "source": "chosen"}
    data["sensors"]["encoder_noise"] = noise
    data["sensors"]["tool_noise"] = {"value": 0.0, "unit": "m", "source": "the true tool is judged"}
    if encoders.links:
        data["sensors"]["link"] = {"position": {"noise": noise}}
    return robot_from_data(data, f"{name} of the study")
