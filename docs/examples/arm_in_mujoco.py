"""A robot arm that is not ours, recorded as its driver records it: python arm_in_mujoco.py URDF BAG [SEED [SECONDS]].

MuJoCo simulates the arm of a URDF with what a URDF leaves out (rotors behind the gears, friction) and with a tool that
nobody told it of. A controller with the rigid model of the URDF tracks a sum of sines at 500 Hz. The bag has what the
driver of a UR5e publishes: joint_states with position, velocity and effort, in the order of the driver, and the URDF.
"""

import sys
from pathlib import Path

import mujoco
import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

RATE, SUBSTEPS = 500, 8  # controller and recorder [Hz]; steps of the simulator in each of their periods
RESOLUTION = 2 * np.pi / 2**20  # of the encoders [rad]
JITTER = 30e-6  # of the stamps, rms [s]
DURATION, LOWEST, HIGHEST = 20.0, 0.05, 0.8  # of the motion [s, Hz]
NANOSECONDS, BEGIN = 10**9, 1_750_000_000  # a date [s]

HOME = np.array([0.3, -1.4, 1.5, -0.9, 1.2, 0.4])  # middle of the motion [rad]

# what the URDF does not say, per joint from the base: kg m2, Nms/rad, Nm; chosen after published figures of UR arms
TRUTH = {
    "armature": (1.4, 1.4, 1.1, 0.25, 0.25, 0.25),
    "damping": (14.0, 13.0, 9.0, 2.6, 2.2, 1.8),
    "frictionloss": (8.5, 9.0, 6.0, 1.7, 1.5, 1.2),
}
TOOL_MASS, TOOL_SIZE, TOOL_AT = 1.5, 0.08, (0.0, 0.0, 0.07)  # kg; edge of a cube and its place at the last link [m]
NOISE = 0.002  # of the measured torque, rms over the limit of the joint


def arm(urdf: Path, *, as_it_is: bool) -> mujoco.MjModel:
    """Read the URDF; as it is in reality, or as the URDF says."""
    spec = mujoco.MjSpec.from_file(str(urdf))
    spec.option.timestep = 1 / RATE / SUBSTEPS
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    if as_it_is:
        for k, joint in enumerate(spec.joints):
            joint.armature, joint.frictionloss = TRUTH["armature"][k], TRUTH["frictionloss"][k]
            joint.damping[0] = TRUTH["damping"][k]
            joint.solref_friction = (2 * spec.option.timestep, 1)  # stiff: nearly no creep at standstill
        own = TOOL_MASS * TOOL_SIZE**2 / 6
        tool = spec.joints[-1].parent.add_body(name="unknown_tool", pos=TOOL_AT, mass=TOOL_MASS, inertia=3 * [own])
        tool.ipos = (0, 0, 0)
        tool.explicitinertial = True
    return spec.compile()


def motion(home: np.ndarray, seed: int) -> np.ndarray:
    """Draw a sum of sines about the home pose that begins and ends at rest [rad], shape (n, joints)."""
    random, t = np.random.default_rng(seed), np.arange(round(DURATION * RATE)) / RATE
    frequency = np.geomspace(LOWEST, HIGHEST, 7)[:, None] * random.uniform(0.9, 1.1, (7, len(home)))
    size = 0.16 / np.sqrt(frequency) / (1 + frequency)
    phase = random.uniform(0, 2 * np.pi, frequency.shape)
    sines = np.sin(2 * np.pi * frequency * t[:, None, None] + phase) * size
    fade = np.clip(np.minimum(t, t[-1] - t) / 2.0, 0, 1)
    return home + (fade**3 * (10 - 15 * fade + 6 * fade**2))[:, None] * sines.sum(axis=1)


def tracked(urdf: Path, reference: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Track a motion; returns measured positions [rad] and torques [Nm], shape (n, joints) each."""
    real, model = arm(urdf, as_it_is=True), arm(urdf, as_it_is=False)
    robot, known = mujoco.MjData(real), mujoco.MjData(model)
    random, limit = np.random.default_rng([seed, 1]), model.jnt_actfrcrange[:, 1]
    speed = np.gradient(reference, 1 / RATE, axis=0)
    kp, kd, ki = (gain * np.array(TRUTH["armature"]) for gain in (3600, 240, 8000))  # its rotors are known to it
    robot.qpos[:] = reference[0]
    positions, torques, integral = np.empty_like(reference), np.empty_like(reference), np.zeros(model.nv)
    last = reference[0]
    for k, (wanted, rate) in enumerate(zip(reference, speed, strict=True)):
        positions[k] = np.round(robot.qpos / RESOLUTION) * RESOLUTION
        known.qpos[:], known.qvel[:] = positions[k], rate
        mujoco.mj_forward(model, known)  # qfrc_bias: gravity and centrifugal torque of the URDF
        error, integral = wanted - positions[k], integral + (wanted - positions[k]) / RATE
        torque = known.qfrc_bias + kp * error + kd * (rate - (positions[k] - last) * RATE) + ki * integral
        robot.qfrc_applied[:] = np.clip(torque, -limit, limit)
        torques[k] = robot.qfrc_applied + NOISE * limit * random.standard_normal(model.nv)
        last = positions[k]
        for _ in range(SUBSTEPS):
            mujoco.mj_step(real, robot)
    return positions, torques


def record(urdf: Path, bag: Path, names: list[str], positions: np.ndarray, torques: np.ndarray, seed: int) -> None:
    """Write joint_states, joints in another order than in the URDF, and robot_description."""
    types = get_typestore(Stores.ROS2_JAZZY)
    States, Header, Time = (
        types.types[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    order = [*range(1, len(names)), 0]  # as the joint_state_broadcaster of a UR5e: shoulder_pan_joint comes last
    velocities = np.gradient(positions, 1 / RATE, axis=0)
    late = np.random.default_rng([seed, 2]).normal(0, JITTER, len(positions))
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        states = writer.add_connection("/joint_states", States.__msgtype__, typestore=types)
        about = writer.add_connection("/robot_description", "std_msgs/msg/String", typestore=types)
        text = types.types["std_msgs/msg/String"](data=urdf.read_text(encoding="utf-8"))
        writer.write(about, BEGIN * NANOSECONDS, types.serialize_cdr(text, "std_msgs/msg/String"))
        for k in range(len(positions)):
            stamp = BEGIN * NANOSECONDS + round((k / RATE + late[k]) * NANOSECONDS)
            header = Header(stamp=Time(*divmod(stamp, NANOSECONDS)), frame_id="base_link")
            values = (each[k][order].copy() for each in (positions, velocities, torques))
            message = States(header, [names[joint] for joint in order], *values)
            writer.write(states, stamp, types.serialize_cdr(message, States.__msgtype__))


if __name__ == "__main__":
    description, folder = Path(sys.argv[1]), Path(sys.argv[2])
    number = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    DURATION = float(sys.argv[4]) if len(sys.argv) > 4 else DURATION
    joints = [joint.name for joint in mujoco.MjSpec.from_file(str(description)).joints]
    measured = tracked(description, motion(HOME, number), number)
    record(description, folder, joints, *measured, number)
    print(f"{folder}: {len(measured[0])} samples of {len(joints)} joints")
