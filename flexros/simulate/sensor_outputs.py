"""What further sensors of a plant show without noise: behind the springs, in the joints and at the tool."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.loop.functions import WRENCH_SIZE
from flexros.robot.symbolic.tool_sensors import tool_acceleration, turning_rate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.robot import Robot
    from flexros.robot.further_sensors import FurtherSensor
    from flexros.simulate.plant_symbols import PlantSymbols


def sensor_outputs(plant: PlantSymbols, derivative: ca.Function, wanted: Sequence[tuple[str, int]]) -> ca.Function:
    """Build the outputs of further sensors as a function (x, u, p) -> y.

    The link position is the arm coordinate q_a behind the gear, the link speed its rate. The joint torque is the one
    from the gear to the arm, on the side of the gear that the robot file states, with all effects in the gear: torque
    of spring and damper, f(q_m - q_a) + d (v_m - v_a); behind a rigid gear the torque M_a a - c - g that moves the arm.
    The accelerometer shows R' (a - g) at the tool, the gyroscope the turning rate of the tool, both in the frame of the
    sensor, which is that of the tool unless the robot file mounts it otherwise.

    Args:
        plant: Symbols of the plant.
        derivative: Its state derivative from (x, u, w, p).
        wanted: Quantity, see `SENSOR_QUANTITIES`, and number of the motor or of the axis, of each sensor.

    Returns:
        Outputs in the order of `wanted`, SX (n_sensors, 1).
    """
    found = _outputs(plant, derivative, wanted, plant.u, ca.SX.zeros(WRENCH_SIZE))
    return ca.Function("sensors", [plant.x, plant.u, plant.p], [ca.densify(found)], {"cse": True})


def measured_sensors(plant: PlantSymbols, derivative: ca.Function, sensors: Sequence[FurtherSensor]) -> ca.Function:
    """Build the outputs of the sensors of a robot as a function (x, p) -> y, under the input that acts.

    A jump of torque or wrench at a sampling instant shows one sample later: the sensor has seen what acted before.

    Args:
        plant: Symbols of the plant; it holds its input where `feels_input`.
        derivative: Its state derivative from (x, u, w, p).
        sensors: Sensors, all their channels in order.
    """
    wanted = [(sensor.quantity, index) for sensor in sensors for index in sensor.indices]
    acting = plant.x[plant.input_rows]
    m = plant.robot.n_motors if acting.numel() else 0
    torque, wrench = (acting[:m], acting[m:]) if m else (ca.SX.zeros(plant.u.numel()), ca.SX.zeros(WRENCH_SIZE))
    found = _outputs(plant, derivative, wanted, torque, wrench)
    return ca.Function("further", [plant.x, plant.p], [ca.densify(found)], {"cse": True})


def feels_input(robot: Robot, sensors: Sequence[FurtherSensor]) -> bool:
    """Return whether a sensor depends on accelerations, and so on motor torques and wrench that act."""
    stiff = set(robot.stiff_motors)
    return any(
        sensor.quantity == "tool acceleration" or (sensor.quantity == "joint torque" and stiff & set(sensor.indices))
        for sensor in sensors
    )


def _outputs(
    plant: PlantSymbols, derivative: ca.Function, wanted: Sequence[tuple[str, int]], torque: ca.SX, wrench: ca.SX
) -> ca.SX:
    """Return the outputs in the order of `wanted`, SX (n_sensors, 1), under motor torques and a wrench at the tool."""
    n, nq = plant.model.n_arm, plant.model.n_coordinates
    acceleration = derivative(plant.x, torque, wrench, plant.p)[nq : nq + n]
    found = []
    for quantity, index in wanted:
        row = 0 if quantity.startswith("tool") else plant.robot.gear_rows[index]
        match quantity:
            case "link position":
                found.append(plant.q[row])
            case "link speed":
                found.append(plant.v[row])
            case "joint torque":
                found.append(_joint_torque(plant, index, acceleration, wrench))
            case "tool acceleration":
                gravity = ca.vertcat(*[ca.SX(plant.robot_value(f"gravity.{axis}")) for axis in "xyz"])
                arm, p = (plant.q[:n], plant.v[:n]), plant.robot_parameters
                found.append(tool_acceleration(plant.model, *arm, acceleration, gravity, p)[index])
            case _:
                found.append(turning_rate(plant.model, plant.q[:n], plant.v[:n], plant.robot_parameters)[index])
    return ca.vertcat(*found)


def _joint_torque(plant: PlantSymbols, motor: int, acceleration: ca.SX, wrench: ca.SX) -> ca.SX:
    """Return the torque from the gear of a motor to the arm."""
    row, n = plant.robot.gear_rows[motor], plant.model.n_arm
    if plant.robot.motors[motor].flexible:
        return plant.gear_torque(motor)
    torque = plant.model.arm_inverse_dynamics(plant.q[:n], plant.v[:n], acceleration, plant.robot_parameters)[row]
    if not wrench.is_zero():
        torque -= _felt_wrench(plant, wrench)[row]
    for law, arm_effect in plant.laws.arms:
        torque -= arm_effect.force(plant.arm(law), plant.values(law))[row]
    return torque


def _felt_wrench(plant: PlantSymbols, wrench: ca.SX) -> ca.SX:
    """Return the forces of a wrench at the tool on the coordinates, SX (nq, 1)."""
    force, still = plant.model.force, ca.SX.zeros(plant.u.numel())
    loaded, free = (force(plant.q, plant.v, still, w, plant.robot_parameters) for w in (wrench, 0 * wrench))
    return loaded - free
