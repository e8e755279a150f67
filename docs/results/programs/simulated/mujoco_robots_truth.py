"""What the arms of mujoco_robots.md hide, and their logs by MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import mujoco
import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

    from mujoco_robots_arms import Arm

    from flexros.arrays import FloatArray

Mode = Literal["torque", "elastic", "backlash", "delay", "servo", "many"]
Causes = dict[tuple[str, str], float]
RATE = 250
"""Samples and commands per second."""
DURATION = 16.0
"""Duration of each log [s]."""
NOISE = 2e-5
"""Noise of the encoders, rms [rad]."""
STEP = 2e-4
"""Time step of MuJoCo [s]."""
SETTLING = 2.0
"""Time under control before the log begins [s]."""
BANDWIDTH = 1.5
"""Of the controller that makes the torques [Hz]."""
FASTEST = 3.0
"""Largest speed that it wants [rad/s]; at a step of the reference it is more."""
DRY_TIME = 2.5 * STEP
"""Time constant of MuJoCo's dry friction [s]."""


@dataclass(frozen=True)
class Truth:
    """What differs from the nominal arm.

    Attributes:
        causes: Size by effect and motor, or "tool", in the unit of its first parameter; delays are apart.
        rotors: Rotor inertias where the nominal arm has none [kg m2], by motor.
        delay: Commands act so many samples late.
        sensor_delay: Positions are noted so many samples late.
        measured: Whether the log has the torques of the motors, not the commands.
        noted: Samples by which torques are noted after the begin of their action.
    """

    causes: Causes
    rotors: dict[str, float] = field(default_factory=dict)
    delay: int = 0
    sensor_delay: int = 0
    measured: bool = False
    noted: int = 0

    @property
    def late(self) -> float:
        """Time by which the motion is late to the torques of the log [s].

        Torques that were measured are those of a sample, in the middle of which they act. Half a sample is that of a
        recorder and no delay.
        """
        samples: float = self.delay + self.sensor_delay
        if self.measured:
            samples += 0.5 - self.noted
        return samples / RATE if samples > 0.5 else 0.0


CHANGED = (
    "coulomb_friction",
    "viscous_friction",
    "motor_inertia_error",
    "stiffness_error",
    "torque_gain_error",
    "servo_stiffness_error",
    "servo_damping_error",
)
"""Effects that are numbers of the compiled model."""
LEAST_MASS = 1e-3
"""Mass of a body that carries a load [kg]; rotors and frames have less."""


def drawn_truth(arm: Arm, mode: Mode, seed: int) -> Truth:
    """Draw what an arm hides: friction at most joints, and what the mode is about.

    Args:
        arm: The nominal arm.
        mode: What is tried.
        seed: Seed of the draw.
    """
    random = np.random.default_rng([seed, 2])
    motors = [f"motor_{k + 1}" for k in range(arm.n_motors)]
    if mode == "many":
        return _everywhere(arm, motors, random)
    causes: Causes = {}
    rotors, lacks = {}, _lacks_rotors(arm)
    for motor, inertia in zip(motors, arm.inertias.tolist(), strict=True):
        if random.random() < 0.6:
            causes["coulomb_friction", motor] = inertia * float(random.uniform(0.8, 4.0))
        if random.random() < 0.4:
            causes["viscous_friction", motor] = inertia * float(random.uniform(0.5, 2.5))
        if lacks:
            rotors[motor] = inertia * float(random.uniform(0.4, 1.5))
        elif random.random() < 0.25:
            causes["motor_inertia_error", motor] = _relative(random, 0.15, 0.5)
    measured, noted = bool(random.random() < 0.5), int(random.random() < 0.5)
    one, late, half = str(random.choice(motors)), 0, bool(random.random() < 0.5)
    if mode == "servo":
        for motor in motors:
            if random.random() < 0.5:
                causes["servo_stiffness_error", motor] = float(np.expm1(random.uniform(-0.7, 0.7)))
        late = int(random.integers(1, 4)) if half else 0
        return Truth(causes, rotors, delay=late)
    if mode == "delay":
        late = int(random.integers(1, 6))
    elif mode == "torque":
        if half:
            causes["tool_load", "tool"] = float(random.uniform(0.2, 0.8))
        if not measured and random.random() < 0.4:
            causes["torque_gain_error", one] = _relative(random, 0.08, 0.2)
    elif mode == "elastic":
        causes["stiffness_error", one] = _relative(random, 0.25, 0.6)
    else:
        causes["backlash", one] = float(random.uniform(3e-3, 2e-2))
    delay, sensor_delay = (late, 0) if half else (0, late)
    return Truth(causes, rotors, delay, sensor_delay, measured, noted if measured else 0)


def _everywhere(arm: Arm, motors: list[str], random: np.random.Generator) -> Truth:
    """Draw friction, a constant torque and a rotor at every joint, gains at two thirds of them, a load and a delay."""
    causes: Causes = {("tool_load", "tool"): float(random.uniform(0.3, 0.8))}
    rotors = {}
    for motor, inertia in zip(motors, arm.inertias.tolist(), strict=True):
        causes["coulomb_friction", motor] = level = inertia * float(random.uniform(1.0, 4.0))
        causes["viscous_friction", motor] = inertia * float(random.uniform(1.0, 2.5))
        causes["torque_bias", motor] = level * _relative(random, 0.3, 0.8)
        rotors[motor] = inertia * float(random.uniform(0.4, 1.5))
    for motor in random.choice(motors, 2 * len(motors) // 3, replace=False):
        causes["torque_gain_error", str(motor)] = _relative(random, 0.08, 0.2)
    return Truth(causes, rotors, delay=int(random.integers(1, 4)))


def _relative(random: np.random.Generator, least: float, most: float) -> float:
    return float(random.uniform(least, most)) * float(random.choice([-1, 1]))


def _lacks_rotors(arm: Arm) -> bool:
    model = mujoco.MjModel.from_xml_path(str(arm.base))
    return not model.dof_armature.any()


def true_model(arm: Arm, truth: Truth) -> Any:
    """Return the true arm, mujoco.MjModel; backlash is no part of it."""
    spec = mujoco.MjSpec.from_file(str(arm.base))
    spec.option.timestep, spec.option.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for (effect, _), size in truth.causes.items():
        if effect == "tool_load":
            last = next(body for body in reversed(spec.bodies) if body.mass > LEAST_MASS)
            load = last.add_body(name="load", pos=2 * last.ipos)
            load.mass, load.inertia, load.explicitinertial = size, [1e-6] * 3, True
    model = spec.compile()
    model.dof_solref[:] = DRY_TIME, 1.0
    for motor, inertia in truth.rotors.items():
        model.dof_armature[model.joint(motor).dofadr] = inertia
    for (effect, place), size in truth.causes.items():
        if effect in CHANGED:
            _change(model, effect, place, size)
    # a step that is implicit in the damping adds half of its length times the damping to the inertia of a joint
    of_rotors = [model.joint(motor).dofadr[0] for motor in truth.rotors]
    rotors = model.dof_armature[of_rotors] - STEP / 2 * model.dof_damping[of_rotors]
    model.dof_armature[of_rotors] = np.maximum(rotors, 0.0)
    return model


def _change(model: Any, effect: str, place: str, size: float) -> None:
    joint = model.joint(place)
    dof, actuator = joint.dofadr[0], int(np.flatnonzero(model.actuator_trnid[:, 0] == joint.id)[0])
    if effect == "coulomb_friction":
        model.dof_frictionloss[dof] = size
    elif effect == "viscous_friction":
        model.dof_damping[dof] += size
    elif effect == "motor_inertia_error":
        model.dof_armature[dof] *= 1 + size
    elif effect == "stiffness_error":
        model.jnt_stiffness[model.joint(place.replace("motor", "gear")).id] *= 1 + size
    elif effect == "torque_gain_error":
        model.actuator_gear[actuator, 0] *= 1 + size
    elif effect == "servo_stiffness_error":
        model.actuator_gainprm[actuator, 0] *= 1 + size
        model.actuator_biasprm[actuator, 1] *= 1 + size
    else:
        model.actuator_biasprm[actuator, 2] *= 1 + size


def reference(arm: Arm, seed: int, duration: float) -> FloatArray:
    """Return reference positions [rad], shape (n, M): sums of sines between pauses, and smooth steps.

    Args:
        arm: The arm.
        seed: Seed of the motion.
        duration: Duration [s].
    """
    random = np.random.default_rng([seed, 3])
    time = np.arange(round(duration * RATE)) / RATE
    home = np.random.default_rng([len(arm.name), 4]).uniform(-0.3, 0.6, arm.n_motors)
    columns = []
    for motor in range(arm.n_motors):
        frequencies = np.array([0.13, 0.35, 0.8, 1.7]) * random.uniform(0.85, 1.15, 4)
        weights = random.uniform(0.6, 1.0) * np.array([0.6, 0.35, 0.12, 0.04])
        phases = random.uniform(0, 2 * np.pi, 4)
        column = np.sin(2 * np.pi * frequencies * time[:, None] + phases) @ weights
        jumps = np.repeat(random.uniform(-0.05, 0.05, round(duration) + 1), RATE)[: len(time)]
        columns.append(home[motor] + np.minimum(time, 1.0) * (column + jumps))
    return np.column_stack(columns)


@dataclass(frozen=True, eq=False)
class Run:
    """A log.

    Attributes:
        driving: Noted torques [Nm] or, of servos, commanded positions [rad], shape (n, M).
        position: Noted positions [rad], shape (n, M).
    """

    driving: FloatArray
    position: FloatArray


def run(arm: Arm, truth: Truth, seed: int, duration: float = DURATION) -> Run:
    """Run the true arm: a controller at the rate of the log commands torques, or its servos follow positions.

    Args:
        arm: The nominal arm, whose gravity the controller knows.
        truth: What it hides.
        seed: Seed of motion and noise.
        duration: Duration [s].
    """
    random = np.random.default_rng([seed, 5])
    model = true_model(arm, truth)
    data = mujoco.MjData(model)
    lead = round(SETTLING * RATE)
    wanted = reference(arm, seed, duration)
    wanted = np.vstack([np.repeat(wanted[:1], lead, axis=0), wanted])
    motors = [f"motor_{k + 1}" for k in range(arm.n_motors)]
    rows = np.array([model.joint(motor).qposadr[0] for motor in motors])
    data.qpos[rows] = wanted[0]
    constant = [truth.causes.get(("torque_bias", motor), 0.0) for motor in motors]
    data.qfrc_applied[[model.joint(motor).dofadr[0] for motor in motors]] = constant
    teeth = [_Teeth(model, place, size) for (effect, place), size in truth.causes.items() if effect == "backlash"]
    controller = _Controller(arm, truth, wanted)
    commands, positions = wanted.copy(), np.empty_like(wanted)
    for k in range(len(wanted)):
        positions[k] = data.qpos[rows] + NOISE * random.normal(size=len(rows))
        if arm.drive == "torque":
            commands[k] = controller.torque(k, positions)
        data.ctrl[:] = commands[max(k - truth.delay, 0)]
        for _ in range(round(1 / RATE / STEP)):
            for tooth in teeth:
                tooth.push(data)
            mujoco.mj_step(model, data)
    samples = np.arange(lead, len(wanted))
    position = positions[samples - truth.sensor_delay]
    return Run(commands[samples - truth.noted], position)


class _Controller:
    """Position and speed of the motors are fed back, and the weight of the nominal arm is held."""

    def __init__(self, arm: Arm, truth: Truth, wanted: FloatArray) -> None:
        self.model = mujoco.MjModel.from_xml_path(str(arm.base))
        self.data = mujoco.MjData(self.model)
        motors = [f"motor_{k + 1}" for k in range(arm.n_motors)]
        self.places = np.array([self.model.joint(motor).qposadr[0] for motor in motors])
        self.rows = np.array([self.model.joint(motor).dofadr[0] for motor in motors])
        self.inertia = arm.inertias + np.array([truth.rotors.get(motor, 0.0) for motor in motors])
        self.wanted = wanted

    def torque(self, k: int, positions: FloatArray) -> FloatArray:
        """Return the torques [Nm] at a sample from the positions up to it [rad], shape (M,), within their limits."""
        wanted, before, rate = self.wanted[k], max(k - 1, 0), 2 * np.pi * BANDWIDTH
        self.data.qpos[self.places] = wanted
        mujoco.mj_forward(self.model, self.data)
        speed = np.clip((wanted - self.wanted[before]) * RATE, -FASTEST, FASTEST)
        errors = rate**2 * (wanted - positions[k])
        errors += 1.6 * rate * (speed - (positions[k] - positions[before]) * RATE)
        torque: FloatArray = self.data.qfrc_bias[self.rows] + self.inertia * errors
        low, high = self.model.actuator_ctrlrange.T
        return np.where(self.model.actuator_ctrllimited, np.clip(torque, low, high), torque)


class _Teeth:
    """A gear with a gap between its flanks, in place of the spring of its joint."""

    def __init__(self, model: Any, motor: str, gap: float) -> None:
        joint = model.joint(motor.replace("motor", "gear"))
        self.row, self.half = joint.dofadr[0], gap / 2
        self.place = joint.qposadr[0]
        self.stiffness, self.damping = float(joint.stiffness[0]), float(joint.damping[0])
        model.jnt_stiffness[joint.id] = model.dof_damping[self.row] = 0.0

    def push(self, data: Any) -> None:
        """Apply the torque of the flank in contact; it only pushes."""
        twist, rate = data.qpos[self.place], data.qvel[self.row]
        depth = abs(twist) - self.half
        if depth <= 0:
            data.qfrc_applied[self.row] = 0.0
            return
        side = 1.0 if twist > 0 else -1.0
        data.qfrc_applied[self.row] = -side * max(self.stiffness * depth + side * self.damping * rate, 0.0)


def write_log(arm: Arm, truth: Truth, log: Run, folder: Path, name: str) -> tuple[Path, Path]:
    """Write a log as a CSV with its mapping, and return both files.

    Args:
        arm: The arm.
        truth: Whether torques are commands or measured.
        log: The log.
        folder: Folder for the files.
        name: Name of the log.
    """
    n = arm.n_motors
    quantity, unit = ("position_command", "rad") if arm.drive == "servo" else ("torque_command", "Nm")
    if truth.measured:
        quantity = "measured_torque"
    columns = [f"  - {{column: q{k}, quantity: position, joint: motor_{k}, unit: rad}}" for k in range(1, n + 1)]
    columns += [f"  - {{column: u{k}, quantity: {quantity}, joint: motor_{k}, unit: {unit}}}" for k in range(1, n + 1)]
    mapping, table = folder / "mapping.yaml", folder / f"{name}.csv"
    text = "\n".join(["name: MuJoCo", "time: {column: time, unit: s}", "columns:", *columns])
    mapping.write_text(text + "\n", encoding="utf-8")
    values = np.column_stack([np.arange(len(log.position)) / RATE, log.position, log.driving])
    header = ",".join(["time", *(f"{letter}{k}" for letter in "qu" for k in range(1, n + 1))])
    np.savetxt(table, values, delimiter=",", header=header, comments="", fmt="%.9g")
    return mapping, table
