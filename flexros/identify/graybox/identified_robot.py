"""The identified robot as a robot file: new values with their source and tolerance.

Parameters that the responses do not determine, or that ended on a bound of the search, may keep their nominal value.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.atomic_file import write_result
from flexros.identify.robot_file import IdentifiedValue, identified_data, identified_file
from flexros.robot.robot import robot_from_data

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

    from flexros.identify.graybox.covariance import ParameterCovariance
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.robot.robot import Robot


def identified_robot(
    robot: Robot, fit: GrayBoxFit, covariance: ParameterCovariance, origin: str = "", kept: Collection[str] = ()
) -> Robot:
    """Return the robot with fitted values, their source and tolerance.

    Args:
        robot: The robot that was identified.
        fit: Fitted values.
        covariance: Their covariance, from which the tolerances come.
        origin: Addition to the source of the values, e.g. the name of the log.
        kept: Names of fitted parameters that keep value, source and tolerance of the robot.

    Raises:
        InputError: The robot with the fitted values is not physical.
    """
    data = identified_data(robot, _values(fit, covariance, kept), _source(fit, origin))
    return robot_from_data(data, f"identified {robot.name}")


def identified_yaml(
    robot: Robot, fit: GrayBoxFit, covariance: ParameterCovariance, origin: str = "", kept: Collection[str] = ()
) -> str:
    """Return the text of the identified robot's file; arguments and errors as for `identified_robot`."""
    return identified_file(robot, _values(fit, covariance, kept), _source(fit, origin))


def write_identified_robot(
    path: Path,
    robot: Robot,
    fit: GrayBoxFit,
    covariance: ParameterCovariance,
    origin: str = "",
    kept: Collection[str] = (),
) -> None:
    """Write the identified robot as a robot file, whole or not at all.

    Args:
        path: File to write.
        robot: The robot that was identified.
        fit: Fitted values.
        covariance: Their covariance.
        origin: Addition to the source of the values.
        kept: Names of fitted parameters that keep value, source and tolerance of the robot.

    Raises:
        InputError: The file cannot be written, or the robot with the fitted values is not physical.
    """
    write_result(path, identified_yaml(robot, fit, covariance, origin, kept), "identified robot")


def _values(fit: GrayBoxFit, covariance: ParameterCovariance, kept: Collection[str]) -> dict[str, IdentifiedValue]:
    rows = zip(fit.names, fit.values.tolist(), covariance.relative.tolist(), strict=True)
    return {name: IdentifiedValue(value, relative) for name, value, relative in rows if name not in kept}


def _source(fit: GrayBoxFit, origin: str) -> str:
    return f"identified by FlexROS, {fit.estimator} with {fit.weights} weights{', ' + origin if origin else ''}"
