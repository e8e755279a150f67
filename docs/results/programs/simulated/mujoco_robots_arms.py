"""Nominal arms of mujoco_robots.md: arms drawn with a seed, and robots from URDF files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import mujoco
import numpy as np

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched
from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.arrays import FloatArray

Drive = Literal["torque", "servo"]
HEAD = """<mujoco model="{name}">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.0002" gravity="0 0 {gravity}" integrator="implicitfast"/>
  <worldbody>
"""
LIGHT = '<inertial pos="0 0 0" mass="1e-9" diaginertia="1e-9 1e-9 1e-9"/>'
"""Body of a rotor, whose inertia is the armature of its joint."""
DRY = 'frictionloss="0" solreffriction="0.0005 1"'
"""Dry friction that hardly creeps: MuJoCo's is a constraint with a time constant."""


@dataclass(frozen=True, eq=False)
class Arm:
    """A nominal arm.

    Attributes:
        name: Its name.
        base: Its MJCF, whose joints with an actuator are named motor_1, motor_2, ...
        robot: Its robot file, imported.
        drive: Whether torques or positions are commanded.
        elastic: Whether its gears have springs, the joints gear_1, gear_2, ...
        inertias: Inertia that each motor moves, near which sizes are drawn [kg m2], shape (M,).
    """

    name: str
    base: Path
    robot: Path
    drive: Drive
    elastic: bool
    inertias: FloatArray

    @property
    def n_motors(self) -> int:
        """Number of motors."""
        return len(self.inertias)


def drawn_arm(seed: int, folder: Path, *, drive: Drive = "torque", elastic: bool = False) -> Arm:
    """Draw an arm of two to four joints, one in three without gravity, and import it from its MJCF.

    Args:
        seed: Seed of the arm.
        folder: Folder for its files.
        drive: Whether torques or positions are commanded.
        elastic: Whether its gears have springs, of 4 to 12 Hz.
    """
    random = np.random.default_rng([seed, 1])
    n = int(random.integers(2, 4 if elastic else 5))
    level = random.random() < 1 / 3  # axes upright: no gravity on any of them
    axes = ["0 0 1" if level or (k == 0 and random.random() < 0.5) else "0 1 0" for k in range(n)]
    lengths = random.uniform(0.15, 0.4, n)
    masses: FloatArray = float(random.uniform(2.5, 5.0)) * 0.6 ** np.arange(n, dtype=np.float64)
    carried = [_carried(lengths, masses, k) for k in range(n)]
    armatures = np.array(carried) * random.uniform(0.3, 1.2, n)
    inertias = armatures + carried
    dampings = random.uniform(0.1, 0.4, n) * inertias
    gears = (2 * np.pi * random.uniform(4.0, 12.0, n)) ** 2 * carried
    rates, ratios = 2 * np.pi * random.uniform(2.5, 5.0, n), random.uniform(0.5, 1.0, n)
    text = HEAD.format(name=f"arm_{seed}", gravity=0.0 if level else -9.81)
    for k in range(n):
        place = f"{lengths[k - 1] if k else 0:.4f} 0 {0 if k else 0.2}"
        joint = f'axis="{axes[k]}" damping="{dampings[k]:.4g}" armature="{armatures[k]:.4g}" {DRY}'
        inertia = masses[k] * lengths[k] ** 2 / 12
        inertial = (
            f'<inertial pos="{lengths[k] / 2:.4f} 0 0" mass="{masses[k]:.4f}" '
            f'diaginertia="{inertia / 20:.4g} {inertia:.4g} {inertia:.4g}"/>'
        )
        if elastic:
            spring = f'axis="{axes[k]}" stiffness="{gears[k]:.5g}" damping="{0.002 * gears[k]:.4g}" armature="0"'
            text += f'<body name="rotor_{k + 1}" pos="{place}">{LIGHT}<joint name="motor_{k + 1}" {joint}/>\n'
            text += f'<body name="link_{k + 1}">{inertial}<joint name="gear_{k + 1}" {spring}/>\n'
        else:
            text += f'<body name="link_{k + 1}" pos="{place}">{inertial}<joint name="motor_{k + 1}" {joint}/>\n'
    text += "</body>" * (2 * n if elastic else n) + "\n</worldbody>\n<actuator>\n"
    for k in range(n):
        kp, kv = rates[k] ** 2 * inertias[k], 2 * ratios[k] * rates[k] * inertias[k]
        own = f'<motor joint="motor_{k + 1}"/>'
        if drive == "servo":
            own = f'<position joint="motor_{k + 1}" kp="{kp:.4g}" kv="{kv:.4g}"/>'
        text += own + "\n"
    base, robot = folder / "nominal.xml", folder / "robot.yaml"
    base.write_text(f"{text}</actuator>\n</mujoco>\n", encoding="utf-8")
    robot.write_text(robot_from_mjcf(base).text, encoding="utf-8")
    return Arm(f"arm {seed}", base, robot, drive, elastic, inertias)


def arm_of_urdf(file: Path, folder: Path) -> Arm:
    """Import an arm from a URDF and export it to MuJoCo: a URDF has no rotor inertias, so the nominal has none.

    Args:
        file: The URDF.
        folder: Folder for its files.
    """
    base, robot = folder / "nominal.xml", folder / "robot.yaml"
    robot.write_text(robot_from_urdf(file).text, encoding="utf-8")
    base.write_text(export_model(load_patched(robot), "mjcf").text, encoding="utf-8")
    model = mujoco.MjModel.from_xml_path(str(base))
    data = mujoco.MjData(model)
    data.qpos[:] = 0.3
    mujoco.mj_forward(model, data)
    columns = [_momentum(model, data, row) for row in np.eye(model.nv)]
    return Arm(file.stem, base, robot, "torque", False, np.maximum(np.diag(columns), 0.02))


def _momentum(model: Any, data: Any, speed: FloatArray) -> FloatArray:
    """Return the generalised momentum of a motion, the mass matrix times its speed."""
    momentum = np.zeros_like(speed)
    mujoco.mj_mulM(model, data, momentum, speed)
    return momentum


def _carried(lengths: FloatArray, masses: FloatArray, joint: int) -> float:
    """Return the inertia of the stretched links from a joint on [kg m2]."""
    reach = np.concatenate([[0.0], np.cumsum(lengths[joint:])])
    middle = (reach[:-1] + reach[1:]) / 2
    return float(masses[joint:] @ (middle**2 + lengths[joint:] ** 2 / 12))
