"""What accelerometer and gyroscope at the tool show, as symbolic functions of the motion of the arm."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.robot.further_sensors import mounting

if TYPE_CHECKING:
    from flexros.robot.symbolic.model import SymbolicModel


def tool_acceleration(
    model: SymbolicModel, position: ca.SX, velocity: ca.SX, acceleration: ca.SX, gravity: ca.SX, parameters: ca.SX
) -> ca.SX:
    """Return the acceleration at the sensor with gravity, R' (a - g), in its own frame [m/s2], SX (3, 1).

    Args:
        model: The model of the robot, whose file states where the sensor is mounted.
        position: Arm coordinates, SX (N, 1).
        velocity: Their rates.
        acceleration: Their accelerations.
        gravity: Gravity in the base frame [m/s2], SX (3, 1).
        parameters: Free parameters of the model.
    """
    pose = model.tool_pose(position, parameters)
    turned, place, point = _rotation(pose[3:]), mounting(model.specification).position, pose[:3]
    if any(place):
        point = point + turned @ ca.DM(place)
    speed = ca.jtimes(point, position, velocity)
    moved = ca.jtimes(speed, position, velocity) + ca.jtimes(point, position, acceleration)
    return _in_sensor(model, turned.T @ (moved - gravity))


def turning_rate(model: SymbolicModel, position: ca.SX, velocity: ca.SX, parameters: ca.SX) -> ca.SX:
    """Return the turning rate of the tool in the frame of the sensor [rad/s], SX (3, 1): twice conj(Q) Q'.

    Args:
        model: The model of the robot, whose file states where the sensor is mounted.
        position: Arm coordinates, SX (N, 1).
        velocity: Their rates.
        parameters: Free parameters of the model.
    """
    quaternion = model.tool_pose(position, parameters)[3:]
    rate = ca.jtimes(quaternion, position, velocity)
    vector, scalar = quaternion[:3], quaternion[3]
    return _in_sensor(model, 2 * (scalar * rate[:3] - rate[3] * vector - ca.cross(vector, rate[:3])))


def _in_sensor(model: SymbolicModel, vector: ca.SX) -> ca.SX:
    """Turn a vector from the frame of the tool into that of the sensor, SX (3, 1)."""
    angles = mounting(model.specification).orientation
    if not any(angles):
        return vector
    from scipy.spatial.transform import Rotation  # here, because it loads slowly and every run would wait for it

    return ca.DM(Rotation.from_euler("xyz", angles).as_matrix()).T @ vector


def _rotation(quaternion: ca.SX) -> ca.SX:
    """Return the rotation matrix of a unit quaternion x, y, z, w, SX (3, 3)."""
    vector, scalar = quaternion[:3], quaternion[3]
    cross = ca.skew(vector)
    return ca.SX.eye(3) + 2 * scalar * cross + 2 * cross @ cross
