"""What the torques of an arm show of a load that its robot file lacks, or of bodies that are wrong by far."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.left_out.tool_load import ToolLoad, last_moved
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.torques.position_torque import PositionTorque
from flexros.gap.fit.torques.rough_bodies import with_rough_bodies
from flexros.gap.fit.torques.solution import rest_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.gap.fit.torques.solution import Load, TorqueRegression
    from flexros.gap.settings import TorqueStartSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

    Regress = Callable[..., TorqueRegression | None]


def may_carry(robot: Robot) -> bool:
    """Return whether a load would show in the torques of several motors."""
    return robot.n_motors > 1 and bool(last_moved(robot))


def clear_load(
    regress: Regress, robot: Robot, tolerance: Tolerance, lacking: int, settings: TorqueStartSettings
) -> tuple[TorqueRegression | None, ToolLoad | None]:
    """Estimate the load that an arm lacks, and its regression; None for none.

    The weight of many heavy arms is carried by a spring or a gas cylinder at one motor, of which the file says nothing
    either. In the torque of that motor it hides the load, which the others show. It must show without a load: beside
    one it could just take up the weight of a load that is none.
    """
    if not may_carry(robot):
        return None, None
    kind = _kind(robot, lacking)
    without = regress(Tolerance(), load=kind)
    if without is None:
        return None, None
    found = [load_beside(regress, robot, tolerance, without, (), settings)]
    for motor, one in enumerate(robot.motors):
        if found[0] is not None or not one.rotary:
            continue
        relieved = regress(Tolerance(), load=kind, position_torques=(PositionTorque(motor),))
        if relieved is not None and without.rest[motor] > settings.relieved * relieved.rest[motor]:
            found.append(load_beside(regress, robot, tolerance, relieved, (PositionTorque(motor),), settings))
    best = min((one for one in found if one is not None), key=lambda one: rest_of(one[0]), default=None)
    return (None, None) if best is None else best


def load_before_bodies(
    regress: Regress, robot: Robot, tolerance: Tolerance, lacking: int, settings: TorqueStartSettings
) -> tuple[TorqueRegression, ToolLoad] | None:
    """Estimate a load that explains more than errors of all bodies, though not by far; None for no load.

    In a slow motion friction and rotors stand for most of its weight: acceleration and weight of a joint that goes to
    and fro are much alike. A load is four numbers. Where it leaves less than errors of all numbers of the bodies, those
    far beyond their tolerance included, it is not these.

    Args:
        regress: The regression of the log, of a tolerance and a load, beside a counterbalance where there is one.
        robot: The nominal robot.
        tolerance: Parameters of the robot that may deviate.
        lacking: Number of motors whose rotor the robot file leaves out.
        settings: Settings of the regressions.
    """
    loaded = regress(Tolerance(), load="point")
    if loaded is None or not tolerance.names:
        return None
    load = _at_a_point(loaded, robot, settings)
    if load is None or load.mass < settings.light_load * moved_mass(robot):
        return None
    without = regress(Tolerance(), load=_kind(robot, lacking))
    if without is None or lowered(without, loaded, settings) < settings.before_bodies:
        return None
    for bodies, least in (
        (tolerance, settings.before_bodies),
        (with_rough_bodies(tolerance, settings.rough_bodies), 1.0),
    ):
        within = regress(bodies)
        if within is None or lowered(within, loaded, settings) < least:
            return None
    return loaded, load


def bodies_are_off(
    wide: TorqueRegression,
    within: TorqueRegression,
    regress: Regress,
    record: Record,
    settings: TorqueStartSettings,
) -> bool:
    """Return whether errors of the bodies far beyond their tolerance explain torques that nothing else does.

    Held within it, friction, offsets, rotors or a load would stand for them. A last body that alone is wrong is a
    payload error. That a motor has no torque, as where it is not driven, is explained by bodies without weight.

    Args:
        wide: The regression with bodies that are known roughly.
        within: The same with bodies within their tolerance.
        regress: The regression of the log, of a tolerance and a load.
        record: The log.
        settings: Settings of the regressions.
    """
    error = within.rest / np.maximum(within.left, 1e-300)
    torque = np.sqrt(np.nanmean(record.torque**2, axis=0))
    driven = torque > settings.least_share * error
    found = replace(wide, left=np.where(driven, wide.left, within.left))
    if not _explains(found, within, settings):
        return False
    payload = regress(Tolerance(), load="body")
    return payload is None or _explains(found, payload, settings)


def _kind(robot: Robot, lacking: int) -> Load:
    """Return what stands for a load that is none: where the file states rotors, a share of the last body."""
    return "none" if lacking == robot.n_motors else "body"


def load_beside(
    regress: Regress,
    robot: Robot,
    tolerance: Tolerance,
    without: TorqueRegression,
    position_torques: tuple[PositionTorque, ...],
    settings: TorqueStartSettings,
) -> tuple[TorqueRegression, ToolLoad] | None:
    """Estimate the load beside a counterbalance of one motor; None for no load.

    Where the file states rotors, it may state a load too: then it must be clearly elsewhere than the last body, whose
    mass alone is that of a payload error. Errors of the bodies within their tolerance must not explain a light one.

    Args:
        regress: The regression of the log, of a tolerance and a load.
        robot: The nominal robot.
        tolerance: Parameters of the robot that may deviate.
        without: The regression without a load.
        position_torques: The counterbalance; empty for none.
        settings: Settings of the regressions.
    """
    loaded = regress(tolerance, load="point", position_torques=position_torques)
    if loaded is None:
        return None
    load, moved = _at_a_point(loaded, robot, settings), moved_mass(robot)
    if load is None or load.mass < settings.lightest_load * moved or not _explains(loaded, without, settings):
        return None
    if load.mass < settings.light_load * moved:
        tolerated = regress(tolerance, position_torques=position_torques)
        if tolerated is None or not _explains(loaded, tolerated, settings):
            return None
    return loaded, load


def _at_a_point(loaded: TorqueRegression, robot: Robot, settings: TorqueStartSettings) -> ToolLoad | None:
    """Return the load of a regression; None for one that no arm carries.

    It has no mass, or far more than all that moves without it, or is farther from the last joint than any tool.
    """
    mass, moment = float(loaded.load[0]), loaded.load[1:]
    if not 0 < mass <= settings.heaviest_load * moved_mass(robot):
        return None
    if np.linalg.norm(moment) > settings.farthest_load * mass:
        return None
    x, y, z = (moment / mass).tolist()
    return ToolLoad(mass=mass, x=x, y=y, z=z)


def moved_mass(robot: Robot) -> float:
    """Return the mass of all bodies that move [kg]."""
    return sum(robot.parameters[f"body_{k}.mass"].value for k, b in enumerate(robot.spec.bodies, 1) if b.directions)


def _explains(loaded: TorqueRegression, without: TorqueRegression, settings: TorqueStartSettings) -> bool:
    """Return whether a load lowers what is left of the torques by enough, no motor counting for more than that."""
    return lowered(without, loaded, settings) >= settings.explained_by_load


def lowered(before: TorqueRegression, after: TorqueRegression, settings: TorqueStartSettings) -> float:
    """Return the factor by which less is left of the torques, over all motors; none counts for more than is enough.

    Args:
        before: One regression.
        after: Another one of the same torques.
        settings: Settings of the regressions.
    """
    factors = np.minimum(before.left / np.maximum(after.left, 1e-300), settings.explained_by_load)
    return float(np.prod(factors))
