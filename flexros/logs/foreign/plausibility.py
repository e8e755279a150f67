"""Velocities of an imported log and sensors behind the springs, compared with the positions of the motors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.logs.time_series import ImuSeries, JointSeries

ALIKE = 0.9
"""Correlation from which two motions are the same one, up to its sign (chosen)."""

NEAR = 1.5
"""Factor between such motions above which a unit or a gear ratio is wrong (chosen)."""

FEWEST = 50
"""Fewest samples of a velocity that is compared (chosen)."""

CONTRARY = -0.5
"""Correlation of a joint torque with that of the motor below which its sign is wrong (chosen)."""

GRAVITY = (4.0, 20.0)
"""Range of the mean acceleration that a sensor of three axes may show, with gravity [m/s^2] (chosen)."""


def doubts(series: Mapping[str, Any]) -> list[str]:
    """Compare velocities, link-side encoders and joint torques with the motors, and an accelerometer with gravity.

    Args:
        series: Time series of the topics that were imported, by name.

    Returns:
        One sentence for each quantity whose unit, sign or joint looks wrong.
    """
    found: list[str] = []
    states, link = series["joint_states"], series.get("link_states")
    for name in states.names:
        found += _velocity(name, states)
    if link is not None:
        for name in link.names:
            found += _link_position(name, states, link) + _joint_torque(
                name, states, series.get("joint_commands"), link
            )
    imu: ImuSeries | None = series.get("tool_imu")
    whole = np.zeros((0, 3)) if imu is None or imu.acceleration is None else imu.acceleration
    whole = whole[np.all(np.isfinite(whole), axis=1)]
    if len(whole):
        mean = float(np.linalg.norm(whole, axis=1).mean())
        if not GRAVITY[0] < mean < GRAVITY[1]:
            found.append(
                f"tool_acceleration is {mean:.3g} m/s2 in the mean, although it must contain gravity (9.81 m/s2); "
                "check its unit"
            )
    return found


def _velocity(name: str, states: JointSeries) -> list[str]:
    """Compare the way that a velocity adds up to with the position, which noise of either hardly changes."""
    if states.position is None or states.velocity is None:
        return []
    column = states.names.index(name)
    time = (states.stamp - states.stamp[0]) * 1e-9
    both = np.column_stack([time, states.position[:, column], states.velocity[:, column]])
    time, position, velocity = both[np.all(np.isfinite(both), axis=1)].T
    if len(time) < FEWEST:
        return []
    way = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time))])
    line = np.column_stack([np.ones_like(time), time])
    position, way = (one - line @ np.linalg.lstsq(line, one, rcond=None)[0] for one in (position, way))
    if not (np.std(position) > 0 and np.std(way) > 0):
        return []
    correlation, factor = float(np.corrcoef(position, way)[0, 1]), float(np.std(way) / np.std(position))
    if correlation < -ALIKE:
        return [f"the velocity of {name} is opposite to its position; correct the sign (sign: -1) of one of both"]
    if correlation > ALIKE and not 1 / NEAR < factor < NEAR:
        return [
            f"the velocity of {name} is {factor:.3g} times the derivative of its position; check unit, scale and "
            "gear_ratio of both"
        ]
    return []


def _link_position(name: str, states: JointSeries, link: JointSeries) -> list[str]:
    pair = _pair(name, states, "position", link, "position")
    if pair is None:
        return []
    motor, own = pair
    correlation = float(np.corrcoef(motor, own)[0, 1])
    factor = float(np.std(own) / np.std(motor))
    if correlation < -ALIKE:
        return [f"the link of {name} moves against its motor; correct the sign (sign: -1) of one of the positions"]
    if correlation > ALIKE and not 1 / NEAR < factor < NEAR:
        return [f"the link of {name} moves {factor:.3g} times as far as its motor; check unit and gear_ratio"]
    return []


def _joint_torque(name: str, states: JointSeries, commands: JointSeries | None, link: JointSeries) -> list[str]:
    for other in (states, commands):
        pair = None if other is None else _pair(name, other, "effort", link, "effort")
        if pair is not None:
            break
    else:
        return []
    correlation = float(np.corrcoef(*pair)[0, 1])
    if correlation < CONTRARY:
        return [f"the joint torque of {name} is opposite to its motor torque; correct one of the signs (sign: -1)"]
    return []


def _pair(
    name: str, series: JointSeries, field: str, link: JointSeries, link_field: str
) -> tuple[FloatArray, FloatArray] | None:
    """Return a signal of a motor and one of its link where both are known; None where one is missing or constant."""
    motor, own = getattr(series, field), getattr(link, link_field)
    if motor is None or own is None or name not in series.names:
        return None
    at = np.interp(link.stamp, series.stamp, motor[:, series.names.index(name)])
    both = np.column_stack([at, own[:, link.names.index(name)]])
    both = both[np.all(np.isfinite(both), axis=1)]
    if not (len(both) and np.all(np.std(both, axis=0) > 0)):
        return None
    return both[:, 0], both[:, 1]
