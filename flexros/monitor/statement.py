"""What the monitor tells, in words: one sentence for the robot and one for each motor."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.monitor.alarms import Level

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.monitor.disturbance_location import Kind, Suspicion
    from flexros.monitor.gap_monitor import MonitorReading, MotorReading
    from flexros.robot import Robot

CAUSES: dict[Kind, str] = {
    "motor": "friction, torque gain or inertia of the motor",
    "gear": "play or stiffness of the gear",
    "arm": "load, balance or friction behind the gear",
    "tool": "payload or contact",
}
"""What usually acts at a place."""
UNPAIRED = 2.0
"""Time of states without commands from which on that is said [s] (chosen)."""
_WORDS = {Level.WARNING: "warning", Level.ALARM: "alarm"}


def robot_sentence(reading: MonitorReading) -> str:
    """Say how the robot is, and whether that is still known."""
    said = _state(reading)
    if not stands_still(reading):
        return said
    return f"{said}; nothing is watched: for the last {reading.unpaired:.1f} s of joint_states there are no commands"


def stands_still(reading: MonitorReading) -> bool:
    """Tell whether states come without commands of the same time."""
    return reading.unpaired > UNPAIRED


def _state(reading: MonitorReading) -> str:
    if reading.stamp < 0:
        return "waits for joint_states and joint_commands"
    if reading.level is Level.OK:
        return "is finding the robot, and watches it soon" if reading.settling else "no gap beyond what is accepted"
    since = min(motor.alarm.since for motor in reading.motors if motor.alarm.level is reading.level) * 1e-9
    worst = max(reading.motors, key=lambda motor: (motor.alarm.level, motor.alarm.share))
    begin = f"{_WORDS[reading.level]} since {since:.1f} s: "
    if not reading.suspected:
        return f"{begin}robot and model differ, most at {worst.name}; its place is not told"
    kinds = dict.fromkeys(one.place.kind for one in reading.suspected)
    causes = f" ({CAUSES[next(iter(kinds))]})" if len(kinds) == 1 else ""
    return f"{begin}robot and model differ {where(reading.suspected)}{causes}"


def where(suspected: Sequence[Suspicion]) -> str:
    """Name the places that come close, the likeliest first."""
    return " or ".join(one.place.words for one in suspected[:3]) + (" or elsewhere" if len(suspected) > 3 else "")


def motor_sentence(motor: MotorReading, unit: str) -> str:
    """Say how a motor is.

    Args:
        motor: Its reading.
        unit: Unit of its torque, "Nm" or "N".
    """
    told = f"missing torque {motor.torque[1]:.3g} {unit} rms, {motor.slow:.3g} times that of noise"
    if motor.alarm.level is Level.OK:
        return f"no gap: {told}" if motor.slow == motor.slow else "not watched yet"
    begin = f"{_WORDS[motor.alarm.level]} since {motor.alarm.since * 1e-9:.1f} s"
    return f"{begin}: {told}" if motor.slow == motor.slow else f"{begin}; not watched at the moment"


def torque_units(robot: Robot) -> tuple[str, ...]:
    """Give the unit of every motor's torque, "Nm" or "N"."""
    return tuple(motor.torque_unit for motor in robot.motors)


def robot_values(reading: MonitorReading) -> dict[str, float | str]:
    """Give the figures of the robot as a whole, by key."""
    finite = [motor.gap for motor in reading.motors if motor.gap == motor.gap]
    return {
        "gap": max(finite, default=float("nan")),
        "share_of_alarm": max((motor.alarm.share for motor in reading.motors), default=0.0),
        "place": where(reading.suspected) if reading.suspected else "",
        "joint": reading.suspected[0].place.joint if reading.suspected else "",
        "seen": reading.seen,
    }


def motor_values(motor: MotorReading) -> dict[str, float | str]:
    """Give the figures of a motor, by key."""
    return {
        "gap": motor.gap,
        "sudden_over_noise": motor.sudden,
        "torque_over_noise": motor.slow,
        "missing_torque_rms": motor.torque[1],
        "missing_torque_mean": motor.torque[0],
        "missing_torque_floor": motor.torque_floor,
        "share_of_alarm": motor.alarm.share,
        "since_s": motor.alarm.since * 1e-9 if motor.alarm.since >= 0 else "",
    }
