"""Sensors behind the springs of an imported log, compared with those of the motors: unit, sign, joint."""

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

CONTRARY = -0.5
"""Correlation of a joint torque with that of the motor below which its sign is wrong (chosen)."""

GRAVITY = (4.0, 20.0)
"""Range of the mean acceleration that a sensor of three axes may show, with gravity [m/s^2] (chosen)."""


def doubts(series: Mapping[str, Any]) -> list[str]:
    """Compare link-side encoders and joint torques with the motors, and an accelerometer with gravity.

    Args:
        series: Time series of the topics that were imported, by name.

    Returns:
        One sentence for each quantity whose unit, sign or joint looks wrong.
    """
    found = []
    states, link = series["joint_states"], series.get("link_states")
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
