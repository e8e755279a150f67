"""Positions, torques and reference of a log, sample by sample as the plan counts them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.checks.record_timing import check_equal_rates, check_no_gap, sample_numbers
from flexros.logs.stamps import START_NS
from flexros.record.held_commands import LONGEST_HELD, HeldCommands

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.logs.time_series import JointSeries, Log

MOST_HELD = 0.01
"""Largest share of samples without a command of their own, whose torque is the one before (chosen)."""

_NUMBERED = re.compile(r"motor_(\d+)")


@dataclass(frozen=True, eq=False)
class AlignedLog:
    """Signals of a log with one row per measurement.

    Attributes:
        names: Joint names in the order of the motors, length M.
        numbers: Number of the sample of each row, increasing, shape (n,).
        position: Measured motor positions [rad or m], shape (n, M).
        torque: Torque commands [Nm or N], shape (n, M).
        reference: Position reference (speed reference where there is no other), shape (n, M); None where it is missing.
        sample_time: T_s [s].
        warnings: What was found, one sentence each.
        commands: Numbers of the samples that have a command of their own, increasing, shape (n_c,).
    """

    names: tuple[str, ...]
    numbers: IntArray
    position: FloatArray
    torque: FloatArray
    reference: FloatArray | None
    sample_time: float
    warnings: tuple[str, ...]
    commands: IntArray

    @property
    def first_command(self) -> int:
        """Number of the sample of the first command; what acted before it is not known."""
        return int(self.commands[0])

    @property
    def last_command(self) -> int:
        """Number of the sample of the last command; what acted after its sample is not known."""
        return int(self.commands[-1])

    def rows(self, first: int, stop: int, what: str) -> slice:
        """Return the rows of samples first ... stop - 1, all of which must be there.

        Args:
            first: First sample.
            stop: Sample after the last one.
            what: What they belong to, for the text.

        Raises:
            InputError: Samples are missing, or the commands begin later or end earlier.
        """
        check_no_gap(self.numbers, first, stop, self.sample_time, what)
        if first < self.first_command:
            raise InputError(
                f"the commands of the log begin at {self.first_command * self.sample_time:.4f} s, {what} at "
                f"{first * self.sample_time:.4f} s, so the torque that acted is not known; record joint_commands from "
                "the start"
            )
        if stop - 1 > self.last_command:
            raise InputError(
                f"the commands of the log end at {self.last_command * self.sample_time:.4f} s, {what} lasts until "
                f"{(stop - 1) * self.sample_time:.4f} s, so the torque that acted is not known; record joint_commands "
                "to the end, or use the complete blocks (setting partial=true)"
            )
        self._check_no_hole(first, stop, what)
        begin = int(np.searchsorted(self.numbers, first))
        return slice(begin, begin + stop - first)

    def _check_no_hole(self, first: int, stop: int, what: str) -> None:
        """Refuse samples among which many commands in a row are missing."""
        held = np.diff(self.commands) - 1
        before = self.commands[:-1]
        holes = np.flatnonzero((held > LONGEST_HELD) & (before + held >= first) & (before + 1 < stop))
        if holes.size:
            hole = holes[0]
            raise InputError(
                f"{held[hole]} commands in a row are missing at {(before[hole] + 1) * self.sample_time:.4f} s within "
                f"{what}, allowed are {LONGEST_HELD}; record joint_commands without losses"
            )


def align(log: Log, plan: ExperimentPlan, start_stamp: int | None = None) -> AlignedLog:
    """Bring the topics of a log together.

    A measurement and the command with the same stamp belong together; where a command is missing, the one before was
    held. Nothing is interpolated.

    Args:
        log: The log.
        plan: The plan of its experiment.
        start_stamp: Stamp of the plan's sample 0 [ns]; default: 1 s for logs of FlexROS, else the first measurement.

    Returns:
        The signals.

    Raises:
        InputError: A topic is missing, or its joints, rate or stamps do not fit.
    """
    warnings: list[str] = []
    states = log.joint_states
    position = _required(states.position, "joint_states.position", states)
    torques, torque = _torque(log, warnings)
    check_equal_rates(states.stamp, torques.stamp)
    order = _motor_order(states.names, plan.n_motors)
    names = tuple(states.names[i] for i in order)
    if start_stamp is None:
        start_stamp = START_NS if log.provenance.get("scenario") else int(states.stamp[0])
    highest = float(plan.frequency[-1])
    numbers = sample_numbers(states.stamp, start_stamp, plan.sample_time, "joint_states", highest, warnings)
    given = numbers
    if not np.array_equal(torques.stamp, states.stamp):
        given = sample_numbers(torques.stamp, start_stamp, plan.sample_time, "joint_commands", highest, warnings)
        _check_recorded(given, numbers, warnings)
        torque = HeldCommands.of(given, numbers).values(torque)
    return AlignedLog(
        names=names,
        numbers=numbers,
        position=_columns(position, order),
        torque=_columns(torque, _places(names, torques.names, "joint_commands")),
        reference=_reference(log, names, numbers, start_stamp, plan.sample_time, warnings),
        sample_time=plan.sample_time,
        warnings=tuple(warnings),
        commands=given,
    )


def _required(values: FloatArray | None, name: str, series: JointSeries) -> FloatArray:
    """Return values that are there and finite; refuses others with joint and time."""
    if values is None:
        raise InputError(f"the log has no {name}, without which there is no frequency response; record it")
    if not np.all(np.isfinite(values)):
        row, joint = (int(place) for place in np.argwhere(~np.isfinite(values))[0])
        seconds = (int(series.stamp[row]) - int(series.stamp[0])) * 1e-9
        raise InputError(
            f"{name} of {series.names[joint]} is {values[row, joint]} at {seconds:.4f} s of the log "
            f"({np.sum(~np.isfinite(values))} values are not finite); cut the log before it, or record it again"
        )
    return values


def _torque(log: Log, warnings: list[str]) -> tuple[JointSeries, FloatArray]:
    """Take the command, else the measured torque."""
    if log.joint_commands is not None and log.joint_commands.effort is not None:
        return log.joint_commands, _required(log.joint_commands.effort, "joint_commands.effort", log.joint_commands)
    if log.joint_states.effort is not None:
        warnings.append("the log has no joint_commands; the measured torque of joint_states is taken as the input")
    name = (
        "joint_commands.effort (nor joint_states.effort)" if log.joint_states.effort is None else "joint_states.effort"
    )
    return log.joint_states, _required(log.joint_states.effort, name, log.joint_states)


def _motor_order(names: tuple[str, ...], n_motors: int) -> list[int]:
    """Order joints by number where they are called motor_<number>, else as they stand."""
    if len(names) != n_motors:
        raise InputError(
            f"joint_states of the log has {len(names)} joints ({', '.join(names)}), the plan has {n_motors} motors; "
            "give the plan of this log"
        )
    found = [_NUMBERED.fullmatch(name) for name in names]
    if all(found):
        return sorted(range(len(names)), key=lambda i: int(found[i].group(1)))  # type: ignore[union-attr]
    return list(range(len(names)))


def _places(names: tuple[str, ...], given: tuple[str, ...], topic: str) -> list[int]:
    missing = [name for name in names if name not in given]
    if missing:
        raise InputError(
            f"{topic} of the log has no joint {missing[0]}, allowed are the joints of joint_states "
            f"({', '.join(names)}), given are {', '.join(given)}; name the joints alike"
        )
    return [given.index(name) for name in names]


def _check_recorded(given: IntArray, numbers: IntArray, warnings: list[str]) -> None:
    """Count the measurements between the first and the last command that have none of their own."""
    between = numbers[(numbers >= given[0]) & (numbers <= given[-1])]
    missing = len(between) - len(np.intersect1d(given, between, assume_unique=True))
    if missing > MOST_HELD * len(numbers):
        raise InputError(
            f"{missing} of {len(numbers)} measurements have no command with the same stamp, allowed is a share of "
            f"{MOST_HELD:g}; record joint_commands without losses"
        )
    if missing:
        warnings.append(f"{missing} measurements have no command with the same stamp; the command before was held")


def _reference(
    log: Log, names: tuple[str, ...], numbers: IntArray, origin: int, sample_time: float, warnings: list[str]
) -> FloatArray | None:
    """Take the reference where every sample has one."""
    series = log.joint_reference
    if series is None:
        return None
    values = series.velocity if series.position is None else series.position
    if values is None or any(name not in series.names for name in names):
        return None
    given = np.rint((series.stamp - origin) / (sample_time * 1e9)).astype(np.int64)
    places = np.searchsorted(given, numbers)
    there = places < len(given)
    there[there] = given[places[there]] == numbers[there]
    if not np.all(there):
        warnings.append("joint_reference is not there for every sample, so the reference is taken as unknown")
        return None
    rows = values if len(given) == len(numbers) else values[places]
    return _columns(rows, _places(names, series.names, "joint_reference"))


def _columns(values: FloatArray, order: list[int]) -> FloatArray:
    """Order columns; long logs are not copied where they are in order."""
    return values if order == list(range(values.shape[1])) else values[:, order]
