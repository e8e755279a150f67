"""Positions, torques and reference of a log, sample by sample as the plan counts them.

Joints, source of the torque and missing samples are treated as by `flexros.record.read`. The sampling instants come
from the plan.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.checks.record_timing import check_equal_rates, check_no_gap, sample_numbers
from flexros.logs.stamps import START_NS
from flexros.record.joint_columns import motor_columns
from flexros.record.missing_samples import MOST_BRIDGED, bridged_motion
from flexros.record.topic_reader import torque_source
from flexros.record.torques.torque_hold import HeldCommands

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.logs.time_series import JointSeries, Log
    from flexros.record.topic_reader import TorqueSource

MOST_HELD = 0.01
"""Largest share of samples without a measurement, or without a command, of their own (chosen)."""


@dataclass(frozen=True, eq=False)
class AlignedLog:
    """Signals of a log with one row per measurement.

    Attributes:
        names: Joint names in the order of the motors, length M.
        numbers: Number of the sample of each row, increasing, shape (n,).
        position: Measured motor positions, bridged where a few are missing [rad or m], shape (n, M).
        torque: Torques [Nm or N], shape (n, M).
        reference: Position reference (speed reference where there is no other), shape (n, M); None where it is missing.
        sample_time: T_s [s].
        warnings: What is doubtful, one sentence each.
        commands: Numbers of the samples that have a torque of their own, increasing, shape (n_c,).
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
        """Number of the sample of the first command; the torque before it is not known."""
        return int(self.commands[0])

    @property
    def last_command(self) -> int:
        """Number of the sample of the last command; the torque after its sample is not known."""
        return int(self.commands[-1])

    def rows(self, first: int, stop: int, what: str) -> slice:
        """Return the rows of samples first ... stop - 1, none of which may be missing.

        Args:
            first: First sample.
            stop: Sample after the last one.
            what: What they belong to, for messages.

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
        """Reject samples among which many commands in a row are missing."""
        held = np.diff(self.commands) - 1
        before = self.commands[:-1]
        holes = np.flatnonzero((held > MOST_BRIDGED) & (before + held >= first) & (before + 1 < stop))
        if holes.size:
            hole = holes[0]
            raise InputError(
                f"{held[hole]} commands in a row are missing at {(before[hole] + 1) * self.sample_time:.4f} s within "
                f"{what}, allowed are {MOST_BRIDGED}; record joint_commands without losses"
            )


def align(
    log: Log, plan: ExperimentPlan, start_stamp: int | None = None, torque: TorqueSource = "command"
) -> AlignedLog:
    """Bring the topics of a log together.

    A measurement and the command with the same stamp belong together. Where a command is missing, the one before was
    held. Up to `MOST_BRIDGED` missing measurements in a row are interpolated linearly.

    Args:
        log: The log.
        plan: The plan of its experiment.
        start_stamp: Stamp of the plan's sample 0 [ns]; default: 1 s for logs of FlexROS, else the first measurement.
        torque: Torque that is taken where both were recorded.

    Returns:
        The signals.

    Raises:
        InputError: A topic is missing, or its joints, rate or stamps do not fit.
    """
    warnings: list[str] = []
    states = log.joint_states
    columns = _columns_of(states, plan, "joint_states", warnings)
    source = torque_source(log, torque, columns, "the log", warnings)
    series, name = (log.joint_commands, "joint_commands") if source == "command" else (states, "joint_states")
    assert series is not None
    check_equal_rates(states.stamp, series.stamp)
    names = tuple(states.names[i] for i in columns)
    if start_stamp is None:
        start_stamp = START_NS if log.provenance.get("scenario") else int(states.stamp[0])
    highest = float(plan.frequency[-1])
    numbers = sample_numbers(states.stamp, start_stamp, plan.sample_time, "joint_states", highest, warnings)
    every, position = _bridged(numbers, _required(states.position, "joint_states.position", columns), warnings)
    if source == "command":
        columns = _columns_of(series, plan, "joint_commands", warnings, names)
    given = numbers
    if not np.array_equal(series.stamp, states.stamp):
        given = sample_numbers(series.stamp, start_stamp, plan.sample_time, name, highest, warnings)
    given, effort = _finite(given, _required(series.effort, f"{name}.effort", columns))
    if not np.array_equal(given, every):
        _check_recorded(given, every, warnings)
        effort = HeldCommands.of(given, every).values(effort)
    return AlignedLog(
        names=names,
        numbers=every,
        position=position,
        torque=effort,
        reference=_reference(log, plan, names, every, start_stamp, warnings),
        sample_time=plan.sample_time,
        warnings=tuple(warnings),
        commands=given,
    )


def _columns_of(
    series: JointSeries, plan: ExperimentPlan, topic: str, warnings: list[str], states: tuple[str, ...] = ()
) -> list[int]:
    motors = [f"motor_{number}" for number in range(1, plan.n_motors + 1)]
    return motor_columns(series.names, motors, f"{topic} of the log", warnings, owner="the plan", states=states)


def _required(values: FloatArray | None, name: str, columns: list[int]) -> FloatArray:
    """Return the columns of the motors; long logs are not copied where they are in order."""
    if values is None:
        raise InputError(f"the log has no {name}, without which there is no frequency response; record it")
    return values if columns == list(range(values.shape[1])) else values[:, columns]


def _finite(numbers: IntArray, values: FloatArray) -> tuple[IntArray, FloatArray]:
    """Drop samples with a value that is not finite; they count as missing."""
    finite = np.all(np.isfinite(values), axis=1)
    return (numbers, values) if np.all(finite) else (numbers[finite], values[finite])


def _bridged(numbers: IntArray, values: FloatArray, warnings: list[str]) -> tuple[IntArray, FloatArray]:
    """Bridge short holes between samples, shape (n, M); return all numbers, and values for them."""
    numbers, values = _finite(numbers, values)
    if not len(numbers):
        raise InputError("joint_states.position of the log is not finite in any sample; record it again")
    missing = np.diff(numbers) - 1
    short = (missing > 0) & (missing <= MOST_BRIDGED)
    if not np.any(short):
        return numbers, values
    filled = [np.arange(number + 1, number + 1 + n) for number, n in zip(numbers[:-1][short], missing[short])]
    every = np.sort(np.concatenate([numbers, *filled]))
    added = len(every) - len(numbers)
    if added > MOST_HELD * len(every):
        raise InputError(
            f"{added} of {len(every)} samples of joint_states are missing or not finite, allowed is a share of "
            f"{MOST_HELD:g}; record joint_states without losses"
        )
    warnings.append(f"{added} samples of joint_states are missing or not finite; their positions were interpolated")
    measured = np.isin(every, numbers, assume_unique=True)
    whole = np.zeros((len(every), values.shape[1]))
    whole[measured] = values
    return every, bridged_motion(whole, measured)


def _check_recorded(given: IntArray, numbers: IntArray, warnings: list[str]) -> None:
    """Count the samples between the first and the last command that have none of their own."""
    if not len(given):
        raise InputError("the torques of the log are not finite in any sample; record them again")
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
    log: Log, plan: ExperimentPlan, names: tuple[str, ...], numbers: IntArray, origin: int, warnings: list[str]
) -> FloatArray | None:
    """Return the reference where every sample has one."""
    series = log.joint_reference
    if series is None:
        return None
    values = series.velocity if series.position is None else series.position
    if values is None:
        return None
    try:
        columns = _columns_of(series, plan, "joint_reference", [], names)
    except InputError:
        return None
    given = np.rint((series.stamp - origin) / (plan.sample_time * 1e9)).astype(np.int64)
    rows = np.searchsorted(given, numbers)
    found = rows < len(given)
    found[found] = given[rows[found]] == numbers[found]
    if not np.all(found):
        warnings.append("joint_reference is missing in some samples, so the reference is treated as unknown")
        return None
    return _required(values if len(given) == len(numbers) else values[rows], "joint_reference", columns)
