"""Propose the mapping of a bag or table: quantities and joints by names, units and signs by the log and the model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.config.settings import validate
from flexros.config.yaml_file import parse_yaml
from flexros.errors import InputError
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import Clock, LogMapping, MappedColumn
from flexros.logs.foreign.message_rows import message_rows
from flexros.logs.foreign.quantities import TIME_UNITS
from flexros.logs.foreign.signal_source import Signal, open_source
from flexros.logs.foreign.sources.ros_bag import RosBag
from flexros.logs.foreign.usable_rows import FEWEST
from flexros.record.proposal.assumption import Assumption
from flexros.record.proposal.columns import TORQUES, clock_of_column, table_signals
from flexros.record.proposal.effort_unit import effort_unit
from flexros.record.proposal.joints import joints_of_file, match_joints
from flexros.record.proposal.topics import bag_topics
from flexros.record.proposal.turned_joints import turned_joints
from flexros.record.proposal.units import JointSignals, Units, units_of_motion
from flexros.record.proposal.unnamed_commands import UnnamedCommands
from flexros.record.proposal.words import (
    about_commands,
    about_effort,
    about_joints,
    about_left_out,
    about_rate,
    about_signs,
    about_topics,
)
from flexros.record.read import MOST_LOST, read_record
from flexros.robot import robot_from_data
from flexros.robot.exchange.urdf.robot_import import skeleton_from_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.logs.foreign.signal_source import AbstractSignalSource
    from flexros.logs.time_series import Log
    from flexros.record.proposal.found_signals import FoundSignals
    from flexros.record.proposal.joints import JointMatch
    from flexros.record.record import Record
    from flexros.record.topic_reader import TorqueSource
    from flexros.robot import Robot

DESCRIPTION = "robot_description"
"""Topic on which the URDF of a robot is published."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A mapping that was proposed.

    Attributes:
        mapping: The mapping.
        assumptions: What was assumed, in words.
        log: The bag as a log by this mapping.
        robot: The model that it was compared with; None for none.
    """

    mapping: LogMapping
    assumptions: tuple[Assumption, ...]
    log: Log
    robot: Robot | None


def robot_in_bag(bag: Path) -> Robot | None:
    """Return the robot of the URDF that a bag holds on a topic robot_description; None where there is none.

    Args:
        bag: The bag, or a table, which holds none.

    Raises:
        InputError: The URDF is not one serial chain.
    """
    opened, source = open_source(bag), f"{bag}, topic {DESCRIPTION}"
    text = opened.text(DESCRIPTION) if isinstance(opened, RosBag) else None
    return robot_from_data(parse_yaml(skeleton_from_text(text, source), source), source) if text else None


def propose_mapping(
    bag: Path, robot: Robot | None, progress: Callable[[str], None] | None = None, *, rate: float | None = None
) -> Proposal:
    """Propose the mapping of a bag or table of another robot.

    Args:
        bag: The bag: folder of rosbag2, .mcap or .db3 file; or a file of columns with names that tell what they are.
        robot: The model, whose joints the motors are; None to take the joints of the bag in their order.
        progress: Called with the name of each step.
        rate: Rows per second of a table without times [Hz]; None where a column or the messages have them.

    Raises:
        InputError: The bag has no positions of named joints, or these are not those of the model; or a rate of a bag;
            or the columns of a table are not equally long.
    """
    say = progress or (lambda _: None)
    say("reading")
    source = open_source(bag)
    of_bag = isinstance(source, RosBag)
    if of_bag and rate is not None:
        raise InputError(f"{bag} is a bag, whose messages have times: leave the rate out", "rate")
    clock = None if rate is None else validate(Clock, {"rate": rate}, str(bag))
    joints = () if robot is None else joints_of_file(robot).values()
    columns = partial(table_signals, source.names, str(bag), timed=rate is None, joints=joints)
    topics = bag_topics(source.names, str(bag)) if of_bag else columns()
    unnamed = _unnamed_commands(source, topics)
    if unnamed is not None and unnamed.quantity == "torque":
        topics = columns(commands="torque")
    matches = match_joints(robot, topics.joints, str(bag))
    wanted = [topics.signals[quantity][m.joint] for quantity, m in _pairs(topics, matches)]
    signals = source.read(list(dict.fromkeys(wanted)))
    if topics.time:
        times = source.read([topics.time])[topics.time].values
        clock = clock_of_column(topics.time, times[np.isfinite(times)])
        signals = _usable_rows(bag, signals, times * TIME_UNITS[clock.unit])
    elif rate is not None:
        signals = _usable_rows(bag, signals, np.arange(len(next(iter(signals.values())).values)) / rate)
    return _Proposer(bag, robot, topics, matches, signals, say, clock, unnamed).proposal()


def _unnamed_commands(source: AbstractSignalSource, topics: FoundSignals) -> UnnamedCommands | None:
    """Tell by their values what commands are whose names say no quantity; None for none with a position."""
    positions = topics.signals["position"]
    pairs = [(column, positions[joint]) for joint, column in topics.unnamed.items() if joint in positions]
    if not pairs:
        return None
    read = source.read([name for pair in pairs for name in pair])
    return UnnamedCommands.of(*([read[name].values for name in names] for names in zip(*pairs, strict=True)))


def _usable_rows(bag: Path, signals: Mapping[str, Signal], time: FloatArray) -> dict[str, Signal]:
    """Return the rows of a table with a later time than before and values of all columns that have most of theirs."""
    for name, signal in signals.items():
        if len(signal.values) != len(time):
            raise InputError(
                f"{bag} has {len(signal.values)} rows in column '{name}' and {len(time)} times; make them equally long"
            )
    values, messages = {name: signal.values for name, signal in signals.items()}, {}
    if np.isfinite(time).all():
        messages = message_rows(values)
    finite = {name: np.isfinite(own) for name, own in values.items() if name not in messages}
    rows = np.isfinite(time) & np.all([own for own in finite.values() if np.mean(~own) < MOST_LOST], axis=0)
    usable = {}
    for name in values:
        taken = messages.get(name, rows).copy()
        taken &= time > np.maximum.accumulate(np.concatenate([[-np.inf], np.where(taken, time, -np.inf)[:-1]]))
        usable[name] = taken
    if not all(map(np.any, usable.values())):
        return dict(signals)  # the import says what is wrong
    begin = min(time[taken][0] for taken in usable.values())
    return {name: Signal(values[name][taken], time[taken] - begin) for name, taken in usable.items()}


def _pairs(topics: FoundSignals, matches: Sequence[JointMatch]) -> list[tuple[str, JointMatch]]:
    """List quantities of which all joints have a signal, with the joints."""
    whole = [name for name, own in topics.signals.items() if all(m.joint in own for m in matches)]
    return [(name, match) for name in whole for match in matches]


class _Proposer:
    """Collects assumptions."""

    def __init__(
        self,
        bag: Path,
        robot: Robot | None,
        topics: FoundSignals,
        matches: Sequence[JointMatch],
        signals: Mapping[str, Signal],
        say: Callable[[str], None],
        clock: Clock | None,
        unnamed: UnnamedCommands | None,
    ) -> None:
        self.bag, self.robot, self.say, self.clock, self.unnamed = bag, robot, say, clock, unnamed
        self.assumptions: list[Assumption] = []
        self.left_out: dict[str, str] = dict(topics.ignored)
        self.agrees = False  # whether torques agree with what the model needs of this motion
        rotary = [True] * len(matches) if robot is None else [motor.rotary for motor in robot.motors]
        self.joints = JointSignals(topics, signals, matches, dict(zip((m.motor for m in matches), rotary, strict=True)))
        usable = [quantity for quantity in topics.signals if self._is_finite(quantity)]
        self.quantities = self._without_idle_commands(usable)
        torques = [name for name in TORQUES if name in self.quantities]
        self.units = Units({name: unit for name in torques if (unit := self.joints.named_unit(name)) is not None})

    @property
    def topics(self) -> FoundSignals:
        """Names of the signals by quantity and joint."""
        return self.joints.found

    @property
    def matches(self) -> Sequence[JointMatch]:
        """The joints that are motors."""
        return self.joints.matches

    def proposal(self) -> Proposal:
        """Return the mapping, with the log that it makes."""
        first = self.joints.of("position", self.matches[0]).time
        assert first is not None
        if len(first) < FEWEST or not first[-1] > first[0]:
            raise InputError(f"{self.bag} has fewer than {FEWEST} positions with increasing times; give a longer log")
        if self.unnamed is not None:
            columns = [column for joint, column in self.topics.unnamed.items() if joint in self.topics.joints]
            self.assumptions.append(about_commands(columns, self.unnamed))
        self.assumptions.append(about_rate(first, self.clock))
        self.assumptions.append(about_joints(self.robot, self.matches))
        if self.robot is not None:
            self.assumptions.append(about_signs(self.matches))
        others = [joint for joint in self.topics.joints if joint not in {m.joint for m in self.matches}]
        if others:
            self.left_out[f"joints {', '.join(others)}"] = "not in the model"
        if self.topics.of_table:
            for quantity in self.quantities:
                for joint, column in self.topics.signals[quantity].items():
                    if joint not in self.topics.joints:
                        self.left_out[column] = f"no column is the position of {joint or 'the only joint'}"
        motion = units_of_motion(self.joints, self.quantities, modelled=self.robot is not None)
        self.units.units |= motion.units
        self.units.signs |= motion.signs
        self.assumptions += motion.assumptions
        self.say("comparing with the model")
        log = import_log(self._mapping(), [self.bag])
        torques = [name for name in TORQUES if name in self.quantities]
        if torques and self._turn_joints(log, torques[0]):
            log = import_log(self._mapping(), [self.bag])
        if torques and self._about_effort(log, torques):
            log = import_log(self._mapping(), [self.bag])
        if not any(name in self.quantities for name in TORQUES):
            text = "no torque: gap and diagnosis need one, or position commands of servos"
            if "position_command" in self.quantities:
                text = "no torque: the position commands drive the servos of the robot file"
            ground = f"no {'column' if self.topics.of_table else 'topic'} has an effort for every joint"
            if self.topics.currents:
                ground = "the currents have no known torque constant"
            self.assumptions.append(Assumption("effort", text, ground, True))
        if motion.against_degrees and not self.agrees:
            of_position = next(each for each in self.assumptions if each.about == "position")
            self.assumptions[self.assumptions.index(of_position)] = replace(of_position, checked=False)
        if self.left_out:
            self.assumptions.append(about_left_out(self.left_out))
        held = about_topics(self.topics, self.quantities, [match.joint for match in self.matches])
        return Proposal(self._mapping(), (*held, *self.assumptions), log, self.robot)

    def _said(self, quantity: str) -> str:
        """What says that efforts are torques in Nm."""
        if quantity == "torque_command" and self.unnamed is not None and self.unnamed.quantity == "torque":
            return "values far from the positions say so"
        return "names of columns say so" if self.clock else "sensor_msgs says so"

    def _is_finite(self, quantity: str) -> bool:
        """Whether a quantity has finite values at every joint, else it is left out with the reason."""
        own = self.topics.signals[quantity]
        lacking = [m.joint for m in self.matches if m.joint not in own]
        if not lacking:
            lacking = [m.joint for m in self.matches if not np.all(np.isfinite(self.joints.of(quantity, m).values))]
        if lacking and quantity == "position":
            raise InputError(
                f"{self.bag}: the position of {', '.join(lacking)} has values that are not finite; cut these messages "
                "out"
            )
        if lacking:
            named = ", ".join(joint or "the only joint" for joint in lacking)
            found = f", but of {', '.join(own)}" if self.topics.of_table and not own.keys() & lacking else ""
            self.left_out[quantity.replace("_", " ")] = f"without usable values of {named}{found}"
        return not lacking

    def _without_idle_commands(self, quantities: list[str]) -> list[str]:
        """Leave torques out that are commanded as zero though measured ones are not."""
        sizes = {
            name: max(float(np.abs(self.joints.of(name, match).values).max()) for match in self.matches)
            for name in TORQUES
            if name in quantities
        }
        if sizes.get("torque_command") == 0.0 < sizes.get("measured_torque", 0.0):
            columns = (self.topics.signals["torque_command"][match.joint] for match in self.matches)
            self.left_out |= dict.fromkeys(columns, "all zero")
            return [name for name in quantities if name != "torque_command"]
        return quantities

    def _record(self, log: Log, robot: Robot, quantity: str) -> Record:
        """Read a log with the torques of a quantity."""
        kind: TorqueSource = "measured" if quantity == "measured_torque" else "command"
        return read_record(log, robot, name=str(self.bag), torque=kind)

    def _turn_joints(self, log: Log, quantity: str) -> bool:
        """Turn joints that count the other way round, as torques of a quantity show; returns whether there are any."""
        if self.robot is None:
            return False
        turned = turned_joints(self._record(log, self.robot, quantity), self.robot)
        if turned is None:
            return False
        turning = {self.matches[motor].motor for motor in turned.motors}
        said = self.assumptions.index(about_signs(self.matches))
        matches = tuple(
            replace(match, sign=-1 if match.sign > 0 else 1) if match.motor in turning else match
            for match in self.matches
        )
        self.joints = replace(self.joints, matches=matches)
        self.assumptions[said] = about_signs(self.matches, turned)
        return True

    def _about_effort(self, log: Log, torques: Sequence[str]) -> bool:
        """Find what the efforts are; returns whether that changes the mapping."""
        if self.robot is None and self.topics.currents:
            for quantity in torques:
                self._leave_out(quantity, "a current needs a torque constant: give a model, or map it by hand")
            return True
        if self.robot is None:
            ground = f"{self._said(torques[0])}; without a model nothing shows it: some drivers fill in currents"
            taken = f"torques in {self.units.unit(torques[0], rotary=True)}"
            self.assumptions.append(Assumption("effort", taken, ground, torques[0] in self.units.units))
            return False
        changed = False
        for quantity in torques:
            name = self.topics.signals[quantity][self.matches[0].joint].split(".")[0]
            record = self._record(log, self.robot, quantity)
            current = quantity in self.topics.currents
            found = effort_unit(record, self.robot, current=current)
            if current and not found.compared:
                self._leave_out(quantity, "a current whose torque constant no weight shows: map it by hand")
                changed = True
                continue
            if (named := self.joints.named_unit(quantity)) is not None:
                found = replace(found, unit=named, scale=())
            self.units.take_effort(quantity, found, self.robot.joint_names)
            self.assumptions.append(about_effort(name, found, self.robot, self._said(quantity)))
            changed |= found.unit != "Nm" or min(found.signs) < 0
            self.agrees |= bool(found.compared) and found.unit == "Nm"
        return changed

    def _leave_out(self, quantity: str, why: str) -> None:
        """Leave out the signals of a quantity."""
        self.quantities.remove(quantity)
        self.left_out |= dict.fromkeys((self.topics.signals[quantity][m.joint] for m in self.matches), why)
        signals = dict(self.topics.signals)
        if "reference_position" in signals and not any(name in self.quantities for name in TORQUES):
            signals["position_command"] = signals.pop("reference_position")  # nothing else drives the robot
            self.joints = replace(self.joints, found=replace(self.topics, signals=signals))
            self.quantities = ["position_command" if q == "reference_position" else q for q in self.quantities]

    def _mapping(self) -> LogMapping:
        columns = []
        for quantity in self.quantities:
            for match in self.matches:
                sign = match.sign * self.units.signs.get((quantity, match.motor), 1)
                rotary = self.joints.rotary[match.motor]
                columns.append(
                    MappedColumn(
                        column=self.topics.signals[quantity][match.joint],
                        quantity=quantity,
                        joint=match.motor,
                        sign=1 if sign > 0 else -1,
                        unit=self.units.unit(quantity, rotary=rotary),
                        period=self.joints.period(quantity, match),
                        scale=self.units.scale(quantity, match.motor, rotary=rotary),
                    )
                )
        model = f" and robot {self.robot.name}" if self.robot else ""
        text = f"Proposed from the names in {self.bag.name}{model}."
        return LogMapping(name=self.bag.stem, description=text, time=self.clock, columns=tuple(columns))
