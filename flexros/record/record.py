"""The record of a log: motor positions and torques on an even grid, and what else was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.record.premises import MEASURED, SIMULATED

if TYPE_CHECKING:
    from collections.abc import Collection

    from flexros.arrays import BoolArray, FloatArray
    from flexros.record.further_sensors import SensorRecord
    from flexros.record.periodic_parts import PeriodicPart
    from flexros.record.premises import Premises
    from flexros.robot.robot import Commands


@dataclass(frozen=True, eq=False)
class ToolRecord:
    """Positions of the tool, measured.

    Attributes:
        time: Time of the poses since the first sample of the record [s], shape (n_t,); any rate.
        position: Positions in the frame of the tracker [m], shape (n_t, 3).
    """

    time: FloatArray
    position: FloatArray


@dataclass(frozen=True, eq=False)
class Record:
    """Signals of one log, in the units and on the side of the gear that the robot file uses.

    Attributes:
        name: Name of the log, for messages.
        sample_time: Time between two samples [s].
        position: Motor positions from the encoders [rad or m], shape (n, M).
        torque: Torques that acted, each the mean from its sample to the next [Nm or N], shape (n, M).
        valid: Whether a sample was measured; false where messages are missing and values are held, shape (n,).
        late: Samples without a command of their own, in which the one before is held, shape (n,); None where all have
            one.
        bridged: Samples of long holes, whose interpolated positions keep the prediction near the motion; they do not
            count, shape (n,); None where there are none, or where nothing was predicted yet.
        jumps: By how much the clock of the recording jumps before each sample [samples], shape (n,); None where it
            does not.
        velocity: Measured motor speeds [rad/s or m/s], shape (n, M); NaN for motors without, None where not recorded.
        noted: Torques as they were noted with the positions [Nm or N], shape (n, M): measured ones, or commands that
            have the stamps of the positions; NaN for motors without, None where the torque has stamps of its own.
        reference: Reference of the motor positions [rad or m], shape (n, M); None where not recorded.
        tool: Positions seen by a tool tracker; None without one.
        sensors: Further sensors: link-side encoders, joint torque sensors, accelerometer and gyroscope of the tool.
        measured_torque: Whether the torques were measured at the motor, behind the delay of the command.
        torque_shift: Samples of the recorder from the stamp of a noted torque to the middle of the time in which it
            counts [1].
        torque_noise: Standard deviation of the white noise of measured torques [Nm or N], shape (M,); None where it is
            not known.
        recorder_samples: Samples of the recorder in each sample [1]; more than 1 where the rate was lowered.
        simulated: Whether the provenance names a scenario of this program.
        imported: Whether the log was imported from files of a real machine, whose model is never exact.
        command: Commanded positions of servos, each held to the next sample [rad or m], shape (n, M), for a log without
            torques, whose `torque` then follows from the nominal servo; None where torques were recorded.
        command_rate: Commanded speeds of servos [rad/s or m/s], shape (n, M); None where not recorded.
        thinned: Commands of the controller for each one in the log; 1 where all were recorded or nothing is known.
        prescribed: Motors whose measured motion drives the model, as their torque is not known or has nothing to do
            with it; see `flexros.record.prescribed_motion`.
        not_turned: Joints that count the other way round than the robot file, and that the mapping of the log does not
            turn, with their motors; they may be the reason of a gap.
        parts: Periodic parts of the motion, as far as they are known.
        encoder_steps: Resolution of each encoder before its positions were interpolated [rad or m], 0 without one,
            length M; empty where they are as measured.
        first: Number of the first sample, counted from the beginning of simulated time.
        begin: Time of the first sample since the beginning of the log [s]; zero except for a part.
        warnings: What was repaired or is doubtful, one sentence each.
        doubts: Those of them that doubt the nominal model and not the log.
        open_doubts: Those of them that doubt the nominal model or the torques of the log.
    """

    name: str
    sample_time: float
    position: FloatArray
    torque: FloatArray
    valid: BoolArray
    late: BoolArray | None = None
    bridged: BoolArray | None = None
    jumps: FloatArray | None = None
    velocity: FloatArray | None = None
    noted: FloatArray | None = None
    reference: FloatArray | None = None
    tool: ToolRecord | None = None
    sensors: tuple[SensorRecord, ...] = ()
    measured_torque: bool = False
    torque_shift: float = 0.0
    torque_noise: FloatArray | None = None
    recorder_samples: float = 1.0
    simulated: bool = False
    imported: bool = False
    command: FloatArray | None = None
    command_rate: FloatArray | None = None
    thinned: float = 1.0
    prescribed: tuple[int, ...] = ()
    not_turned: tuple[str, ...] = ()
    parts: tuple[PeriodicPart, ...] = ()
    encoder_steps: tuple[float, ...] = ()
    first: int = 0
    begin: float = 0.0
    warnings: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    open_doubts: tuple[str, ...] = ()

    @property
    def premises(self) -> Premises:
        """What a diagnosis takes for granted of the log."""
        return MEASURED if self.imported else SIMULATED

    @property
    def n_samples(self) -> int:
        """Number of samples n."""
        return len(self.position)

    @property
    def commands(self) -> Commands:
        """What commanded the robot, as far as the log says: torques, or positions of servos."""
        return "torque" if self.command is None else "position"

    @property
    def driven_by(self) -> str:
        """What drives the model, in words: measured or commanded torques, or commanded positions."""
        if self.command is not None:
            return "commanded positions"
        return f"{'measured' if self.measured_torque else 'commanded'} torques"

    @property
    def driving(self) -> FloatArray:
        """Input of the model: torques [Nm or N], or commanded positions of servos [rad or m], shape (n, M)."""
        return self.torque if self.command is None else self.command

    @property
    def predicted(self) -> BoolArray:
        """Motors that torques or commands move, so that their motion is predicted and not prescribed, shape (M,)."""
        predicted = np.ones(self.position.shape[1], dtype=bool)
        predicted[list(self.prescribed)] = False
        return predicted

    @property
    def correcting(self) -> BoolArray:
        """Samples whose positions correct the prediction, shape (n,)."""
        return self.valid if self.bridged is None else self.valid | self.bridged

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return (self.n_samples - 1) * self.sample_time

    def without_warnings(self, settled: Collection[str]) -> Record:
        """Return the record without warnings that a repaired model settles."""
        return replace(self, warnings=tuple(text for text in self.warnings if text not in settled))

    def part(self, first: int, end: int) -> Record:
        """Cut out samples first ... end - 1.

        Args:
            first: First sample of the part.
            end: Sample after its last.

        Returns:
            The part. Its time starts at zero; `begin` is its position in the log.
        """
        tool = self.tool
        if tool is not None:
            begin = first * self.sample_time
            inside = (tool.time >= begin) & (tool.time <= (end - 1) * self.sample_time)
            tool = ToolRecord(tool.time[inside] - begin, tool.position[inside])
        ends = first * self.sample_time, max(end - 1, first) * self.sample_time
        cut = slice(first, end)
        kept = (part.within(first, end) for part in self.parts)
        return replace(
            self,
            position=self.position[cut],
            torque=self.torque[cut],
            command=None if self.command is None else self.command[cut],
            command_rate=None if self.command_rate is None else self.command_rate[cut],
            valid=self.valid[cut],
            late=None if self.late is None else self.late[cut],
            bridged=None if self.bridged is None else self.bridged[cut],
            jumps=None if self.jumps is None else self.jumps[cut],
            velocity=None if self.velocity is None else self.velocity[cut],
            noted=None if self.noted is None else self.noted[cut],
            reference=None if self.reference is None else self.reference[cut],
            tool=tool,
            sensors=tuple(sensor.part(*ends) for sensor in self.sensors),
            parts=tuple(part for part in kept if part is not None),
            begin=self.begin + first * self.sample_time,
        )
