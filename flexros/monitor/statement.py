"""Statements of the monitor: one sentence for the robot and one for each motor."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.monitor.alarms import Level

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.monitor.disturbance_location import Kind, LocationGain
    from flexros.monitor.gap_monitor import MonitorReading, MotorReading
    from flexros.robot import Robot

CAUSES: dict[Kind, str] = {
    "motor": "friction, torque gain or inertia of the motor",
    "gear": "backlash or stiffness of the gear",
    "arm": "load, balance or friction behind the gear",
    "tool": "payload or contact",
}
"""Usual causes at a location."""
UNPAIRED = 2.0
"""Time of states without commands after which monitoring counts as suspended [s] (chosen)."""
_WORDS = {Level.WARNING: "warning", Level.ALARM: "alarm"}


def robot_sentence(reading: MonitorReading) -> str:
    """State the condition of the robot, and whether monitoring is suspended."""
    state = _state(reading)
    if not is_suspended(reading):
        return state
    return f"{state}; monitoring suspended: no joint_commands for the last {reading.unpaired:.1f} s of joint_states"


def is_suspended(reading: MonitorReading) -> bool:
    """Return whether states arrive without commands of the same time."""
    return reading.unpaired > UNPAIRED


def _state(reading: MonitorReading) -> str:
    if reading.stamp < 0:
        return "waiting for joint_states and joint_commands"
    if reading.level is Level.OK:
        return (
            "initialising: observer converging" if reading.settling else "no model mismatch beyond the accepted level"
        )
    since = min(motor.alarm.since for motor in reading.motors if motor.alarm.level is reading.level) * 1e-9
    worst = max(reading.motors, key=lambda motor: (motor.alarm.level, motor.alarm.share))
    begin = f"{_WORDS[reading.level]} since {since:.1f} s: "
    if not reading.locations:
        return f"{begin}model mismatch, largest at {worst.name}; location undetermined"
    kinds = dict.fromkeys(entry.location.kind for entry in reading.locations)
    causes = f" ({CAUSES[next(iter(kinds))]})" if len(kinds) == 1 else ""
    return f"{begin}model mismatch {where(reading.locations)}{causes}"


def where(locations: Sequence[LocationGain]) -> str:
    """Name the likely locations, the most likely first."""
    named = " or ".join(entry.location.words for entry in locations[:3])
    return named + (" or elsewhere" if len(locations) > 3 else "")


def motor_sentence(motor: MotorReading, unit: str) -> str:
    """State the condition of a motor.

    Args:
        motor: Its reading.
        unit: Unit of its torque, "Nm" or "N".
    """
    size = f"disturbance torque {motor.torque[1]:.3g} {unit} rms, {motor.disturbance:.3g} times its noise floor"
    if motor.alarm.level is Level.OK:
        return f"no gap: {size}" if motor.disturbance == motor.disturbance else "not yet monitored"
    begin = f"{_WORDS[motor.alarm.level]} since {motor.alarm.since * 1e-9:.1f} s"
    return f"{begin}: {size}" if motor.disturbance == motor.disturbance else f"{begin}; monitoring interrupted"


def torque_units(robot: Robot) -> tuple[str, ...]:
    """Return the unit of every motor's torque, "Nm" or "N"."""
    return tuple(motor.torque_unit for motor in robot.motors)


def robot_values(reading: MonitorReading) -> dict[str, float | str]:
    """Return the figures of the robot as a whole by key."""
    finite = [motor.gap for motor in reading.motors if motor.gap == motor.gap]
    return {
        "gap": max(finite, default=float("nan")),
        "share_of_alarm": max((motor.alarm.share for motor in reading.motors), default=0.0),
        "place": where(reading.locations) if reading.locations else "",
        "joint": reading.locations[0].location.joint if reading.locations else "",
        "seen": reading.seen,
    }


def motor_values(motor: MotorReading) -> dict[str, float | str]:
    """Return the figures of a motor by key."""
    return {
        "gap": motor.gap,
        "sudden_over_noise": motor.innovation,
        "torque_over_noise": motor.disturbance,
        "missing_torque_rms": motor.torque[1],
        "missing_torque_mean": motor.torque[0],
        "missing_torque_floor": motor.torque_floor,
        "share_of_alarm": motor.alarm.share,
        "since_s": motor.alarm.since * 1e-9 if motor.alarm.since >= 0 else "",
    }
