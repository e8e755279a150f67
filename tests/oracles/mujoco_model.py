"""A robot as a MuJoCo model: an independent implementation of the same equations of motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.specification import Body

AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
ROTOR_MASS = 1e-9
"""MuJoCo wants mass in every moving body; inertia of rotors comes as armature instead [kg, kg m2]."""


def mujoco_model(robot: Robot, sample_time: float) -> mujoco.MjModel:
    """Build the model: serial bodies, elastic gears as tendons between arm joint and rotor, RK4.

    Coordinates are those of the robot, [q_a, q_m]; controls are the motor torques. Springs must be linear, gears
    flexible, and friction of bodies against the world absent.
    """
    spec = robot.spec
    bodies, tendons, motors, actuators = [], [], [], []
    for number, body in enumerate(spec.bodies, start=1):
        bodies.append(_body(body, number, spec.bodies[number - 2] if number > 1 else None))
        for axis, direction in body.directions.items():
            if direction.motor is None:
                continue
            name, arm, motor = f"motor_{len(motors) + 1}", f"body_{number}.{axis}", direction.motor
            kind = "hinge" if axis.startswith("r") else "slide"
            motors.append(
                f'<body name="{name}"><inertial pos="0 0 0" mass="{ROTOR_MASS}" diaginertia="{ROTOR_MASS} {ROTOR_MASS} '
                f'{ROTOR_MASS}"/><joint name="{name}" type="{kind}" axis="0 0 1" '
                f'armature="{motor.inertia.value}" damping="{motor.viscous_friction.value}"/></body>'
            )
            tendons.append(
                f'<fixed stiffness="{direction.spring.stiffness.value}" damping="{direction.damper.value}" '
                f'springlength="0"><joint joint="{arm}" coef="-1"/><joint joint="{name}" coef="1"/></fixed>'
            )
            actuators.append(f'<motor joint="{name}"/>')
    gravity = " ".join(str(value) for value in spec.gravity.value)
    text = (
        f'<mujoco><option timestep="{sample_time}" integrator="RK4" gravity="{gravity}">'
        '<flag contact="disable" constraint="disable"/></option><compiler angle="radian"/><worldbody>'
        + "".join(bodies)
        + "</body>" * len(bodies)
        + "".join(motors)
        + f"</worldbody><tendon>{''.join(tendons)}</tendon><actuator>{''.join(actuators)}</actuator></mujoco>"
    )
    return mujoco.MjModel.from_xml_string(text)


def _body(body: Body, number: int, before: Body | None) -> str:
    position = (0.0, 0.0, 0.0) if before is None else before.length.value
    moments = {key: getattr(body.inertia, key).value for key in ("xx", "yy", "zz", "xy", "xz", "yz")}
    if moments["xx"] == moments["zz"] == 0.0:  # planar about y: MuJoCo wants a tensor that a body can have
        moments["xx"] = moments["zz"] = moments["yy"]
    full = " ".join(str(value) for value in moments.values())
    joints = []
    for axis, direction in body.directions.items():
        if direction.spring == "rigid":
            continue
        spring = ""
        if direction.motor is None:
            spring = f'stiffness="{direction.spring.stiffness.value}" damping="{direction.damper.value}"'
        kind = "hinge" if axis.startswith("r") else "slide"
        joints.append(f'<joint name="body_{number}.{axis}" type="{kind}" axis="{AXES[axis[1]]}" {spring}/>')
    mass = body.mass.value
    return (
        f'<body name="body_{number}" pos="{" ".join(map(str, position))}"><inertial mass="{mass}" '
        f'pos="{" ".join(map(str, body.center_of_mass.value))}" fullinertia="{full}"/>{"".join(joints)}'
    )


def mujoco_closed_loop(
    robot: Robot, state: FloatArray, references: FloatArray, kp: FloatArray, kd: FloatArray, sample_time: float
) -> FloatArray:
    """Run a PD on motor positions with feedforward, RK4 of one step per sample, in a Python loop.

    Args:
        robot: The robot.
        state: State at the start, shape (2 nq,).
        references: Motor position and feedforward torque per sample, shape (n, 2 M).
        kp: Proportional gains [Nm/rad], shape (M,).
        kd: Derivative gains [Nms/rad], shape (M,).
        sample_time: Sample time [s].

    Returns:
        Coordinates at the samples, shape (n, nq).
    """
    model = mujoco_model(robot, sample_time)
    data = mujoco.MjData(model)
    nq, n_motors = robot.n_coordinates, robot.n_motors
    data.qpos[:], data.qvel[:] = state[:nq], state[nq:]
    coordinates = np.empty((len(references), nq))
    before = references[0, :n_motors] - data.qpos[-n_motors:]
    for k, reference in enumerate(references):
        coordinates[k] = data.qpos
        error = reference[:n_motors] - data.qpos[-n_motors:]
        data.ctrl[:] = reference[n_motors:] + kp * error + kd * (error - before) / sample_time
        before = error
        mujoco.mj_step(model, data)
    return coordinates
