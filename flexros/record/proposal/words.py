"""What was assumed of topics, rate, joints and efforts, in words."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.missing_samples import PAUSE
from flexros.record.proposal.assumption import Assumption
from flexros.record.proposal.units import unit_words
from flexros.record.proposal.unnamed_commands import NEAR

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.logs.foreign.mapping import Clock
    from flexros.record.proposal.effort_unit import EffortUnit
    from flexros.record.proposal.found_signals import FoundSignals
    from flexros.record.proposal.joints import JointMatch
    from flexros.record.proposal.turned_joints import TurnedJoints
    from flexros.record.proposal.unnamed_commands import UnnamedCommands
    from flexros.robot import Robot

STATES = ("position", "velocity", "measured_torque")
"""Quantities of the topic of states."""


def about_topics(topics: FoundSignals, quantities: Iterable[str], joints: Sequence[str]) -> list[Assumption]:
    """State which topic or which columns hold which quantity.

    Args:
        topics: The signals of the bag or table.
        quantities: Quantities that are used.
        joints: Joints of the bag or table that are motors.
    """
    joint = joints[0]
    if topics.of_table:
        text = "; ".join(
            f"{_words(one)}: {', '.join(topics.signals[one][name] for name in joints)}" for one in quantities
        )
        return [Assumption("columns", text, "words in their names", True)]
    states = ", ".join(_words(quantity) for quantity in quantities if quantity in STATES)
    found = [Assumption("topics", f"{topics.states} holds {states}", "names and fields of the topics", True)]
    for quantity in quantities:
        if quantity not in STATES:
            name = topics.signals[quantity][joint].split(".")[0]
            found.append(Assumption("topics", f"{name} holds the {_words(quantity)}", "name and fields of it", True))
    return found


def about_commands(columns: Iterable[str], found: UnnamedCommands) -> Assumption:
    """State what commands are whose names say no quantity.

    Args:
        columns: Their columns.
        found: What the comparison with the positions shows.
    """
    ground = (
        f"the names do not say it; the rms of their values minus the measured positions is {found.distance:.2g} times "
        f"the rms of these, and that of commands of positions is within {NEAR:g} times"
    )
    return Assumption("commands", f"{', '.join(columns)}: {found.quantity} commands", ground, found.clear)


def about_rate(time: FloatArray, clock: Clock | None = None) -> Assumption:
    """State the rate of the positions.

    Args:
        time: Their times [s], shape (n,).
        clock: The column of times of a table; None for messages.
    """
    duration, steps = float(time[-1] - time[0]), np.diff(time)
    longest, usual = float(steps.max(initial=0.0)), float(np.median(steps))
    rest = float(steps[steps > PAUSE * usual].sum())
    rate = (len(time) - 1) / max(duration - rest, 1e-12)  # without pauses
    text = f"{rate:.5g} Hz over {duration:.4g} s, longest interval {1e3 * longest:.3g} ms"
    ground = "stamps of the messages"
    if clock is not None:
        ground = f"column {clock.column}, taken in {clock.unit}" if clock.column else "rate that was given"
    return Assumption("rate", text, ground, True)


def about_joints(robot: Robot | None, matches: Sequence[JointMatch]) -> Assumption:
    """State which joint is which motor.

    Args:
        robot: The model.
        matches: The joints.
    """
    text = ", ".join(f"{match.motor} = {match.joint or 'the only joint'}" for match in matches)
    if robot is None:
        return Assumption("joints", text, "no model was given: the joints of the log in their order", False)
    if any(match.found == "order" for match in matches):
        ground, sure = f"no name of robot {robot.name} is in the log: guessed by their order", False
    elif any(match.found == "own words" for match in matches):
        ground, sure = "the names in the log are those of the model, but for words that any joint may have", True
    elif any(match.found != "name" for match in matches):
        ground, sure = "the names in the log end with those of the model", True
    else:
        ground, sure = "the names in the log are those of the model, whatever their order", True
    return Assumption("joints", text, ground, sure)


def about_signs(matches: Sequence[JointMatch], turned: TurnedJoints | None = None) -> Assumption:
    """State which way the joints count.

    Args:
        matches: The joints.
        turned: Those of them that were turned because their torques say so; None for none.
    """
    against = [match.joint for match in matches if match.sign < 0]
    signs, why = "all joints count as in the log", "no axis of the robot file is said to be opposite"
    if against:
        signs = f"{', '.join(against)} with the opposite sign, all others as in the log"
        why = "the axis in the URDF or MJCF points against that of the robot file there"
    if turned is not None:
        names, *others = (
            ", ".join(matches[motor].joint for motor in motors) for motors in (turned.motors, *turned.alike)
        )
        names += f" (or, which fits as well, of {' or of '.join(others)})" if others else ""
        why = (
            f"with position, velocity and torque of {names} turned round, which the robot file does not ask for, model "
            f"and friction leave {turned.after:.1%} of the torques unexplained instead of {turned.before:.1%}; import "
            "other logs of this recorder with this file"
        )
    return Assumption("signs", signs, why, True)


def about_left_out(reasons: Mapping[str, str]) -> Assumption:
    """State what was left out: columns of one matrix and one reason together.

    Args:
        reasons: Why each topic, column or quantity was left out, by its name.
    """
    alike: dict[tuple[str, str], list[str]] = {}
    for name, why in reasons.items():
        stem = re.sub(r"\d+", "", name)
        alike.setdefault((stem, re.sub(r"\d+", "", why)), []).append(name)
    parts = []
    for names in alike.values():
        named = names[0] or "a column without a name"
        named += f" to {names[-1]}" if len(names) > 2 else f", {names[1]}" if len(names) == 2 else ""
        parts.append(f"{named} ({reasons[names[0]]})")
    return Assumption("others", f"left out: {'; '.join(parts)}", "map them by hand where they matter", True)


def _words(quantity: str) -> str:
    return quantity.replace("_", " ")


def about_effort(topic: str, found: EffortUnit, robot: Robot, said: str) -> Assumption:
    """State what an effort is taken for.

    Args:
        topic: Its topic, or its first column.
        found: What the comparison with the model shows.
        robot: The model.
        said: What says that efforts are torques in Nm.
    """
    opposite = [name for name, sign in zip(robot.joint_names, found.signs, strict=True) if sign < 0]
    rotary = {motor.name: motor.rotary for motor in robot.motors}
    kind = "torque" if any(rotary.values()) else "force"
    taken = f"effort of {topic}: {kind} in {unit_words(found.unit, rotary)}"
    if found.unit == "A":
        scales = ", ".join(f"{name} {scale:g}" for name, scale in zip(robot.joint_names, found.scale, strict=True))
        taken = f"effort of {topic}: a current in A (or another unit), with {scales} Nm/A"
    if opposite:
        taken += f", opposite at {', '.join(opposite)}"
    if not found.compared:
        ground = f"{said}; friction, or little motion, hides what the model needs, so that nothing shows it"
        return Assumption("effort", taken, ground, False)
    sizes = ", ".join(f"{name} {factor:.3g}" for name, factor in found.compared.items())
    ground = (
        f"effort over the torque that the model needs: {sizes}; weighted by that torque {found.level:.3g}, and a "
        "torque is within 0.37 to 2.7"
    )
    if found.alone:
        ground += "; one joint alone shows no unit: a spring or a load there does as much"
    if found.unit == "A":
        ground += "; these constants make the weights of the model true, so an error of the torque gain cannot be found"
    return Assumption("effort", taken, ground, found.unit != "A" and not found.alone)
