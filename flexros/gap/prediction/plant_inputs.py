"""Inputs of a plant under a hypothesis: torques or servo commands of a log, cut off and delayed by its candidates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.command_delay import split_delay
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.gap.prediction.compiled_plant import delays
from flexros.gap.prediction.fractional_delay import delayed_commands, delayed_halves
from flexros.simulate.servo_lead import servo_leads

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence
    from typing import TypeAlias

    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.record.record import Record

    Values: TypeAlias = Sequence[Mapping[str, float]]
    """Values of the free parameters of every candidate [their units]."""


@dataclass(frozen=True, eq=False)
class ParameterSet:
    """One set of fitted parameters, decoded.

    Attributes:
        values: Values of the free parameters of every candidate [their units].
        column: Parameters of the plant [SI], shape (n_parameters,).
    """

    values: Values
    column: FloatArray


class PlantInputs:
    """Makes the inputs of a plant from the record of the commands.

    Args:
        plant: The plant; its delay acts behind these inputs unless candidates delay them.
        hypothesis: The candidates.
        sample_time: Time between two samples [s].

    Attributes:
        saturated: Whether a candidate saturates torques that another one delays, of each candidate. It is applied here
            then, and not in the plant: the order does not matter to the robot, but the halves of a delayed sample hold
            only for torques that are not saturated after it.
    """

    def __init__(self, plant: CompiledPlant, hypothesis: Hypothesis, sample_time: float) -> None:
        self._plant, self._robot = plant, plant.robot
        self._hypothesis, self._sample_time = hypothesis, sample_time
        self._delaying = [one for one in hypothesis if delays(one)]
        self.saturated = tuple(map(self._is_saturated_before, hypothesis))

    def driving(self, record: Record, sets: Sequence[ParameterSet]) -> FloatArray:
        """Return the input of every part of a sample, with a last axis of sets where these differ.

        Args:
            record: The log.
            sets: The sets of parameters.
        """
        inputs = self._undelayed(record, sets)
        if not self._delaying:
            return inputs[0] if len(inputs) == 1 else np.stack(inputs, axis=-1)
        inputs = inputs * len(sets) if len(inputs) == 1 else inputs
        if self._plant.parts == 1:
            late = [self._filtered(one, own.values) for one, own in zip(inputs, sets, strict=True)]
        else:
            delayed = [self._late(own.values, record.prescribed) / self._sample_time for own in sets]
            made: dict[tuple[int, bytes], FloatArray] = {}  # most sets of a fit have the same delays
            late = []
            for one, delay in zip(inputs, delayed, strict=True):
                key = id(one), delay.tobytes()
                if key not in made:
                    made[key] = delayed_halves(one, delay)
                late.append(made[key])
        return late[0] if len(late) == 1 else np.stack(late, axis=-1)

    def acting(self, record: Record, sets: Sequence[ParameterSet], samples: IntArray) -> FloatArray:
        """Return the mean of the inputs just before and just after samples, shape (m, M, sets or 1).

        Args:
            record: The log.
            sets: The sets of parameters.
            samples: The samples, shape (m,).
        """
        inputs = self._undelayed(record, sets)
        differing = sets[: None if self._delaying else 1]
        late = np.stack([self._late(own.values, record.prescribed) for own in differing], axis=-1)
        lanes = range(max(len(inputs), late.shape[1]))
        acting = np.empty((len(samples), self._robot.n_motors, len(lanes)))
        for lane in lanes:
            held = inputs[min(lane, len(inputs) - 1)]
            for motor, delay in enumerate(late[:, min(lane, late.shape[1] - 1)]):
                split = split_delay(float(delay), self._sample_time)
                after = np.maximum(samples - split.line_length, 0)
                before = after if split.fraction > 0.0 else np.maximum(after - 1, 0)
                acting[:, motor, lane] = 0.5 * (held[after, motor] + held[before, motor])
        return acting

    def _undelayed(self, record: Record, sets: Sequence[ParameterSet]) -> list[FloatArray]:
        """Return the input of the model before all delays, of each set or one of all, shape (n, M) each."""
        if record.command is None:
            inputs = [record.torque]
        else:
            names = self._plant.model.parameter_names
            leads = [servo_leads(self._robot, dict(zip(names, one.column))) for one in sets]
            rate = record.command_rate
            rate = np.gradient(record.command, record.sample_time, axis=0) if rate is None else rate
            inputs = [record.command + lead * rate for lead in leads] if np.any(leads) else [record.command]
        if not any(self.saturated):
            return inputs
        inputs = inputs * len(sets) if len(inputs) == 1 else inputs
        return [self._cut_off(one, own.values) for one, own in zip(inputs, sets, strict=True)]

    def _filtered(self, commands: FloatArray, values: Values) -> FloatArray:
        """Delay the position commands of servos, beyond the delay of the robot."""
        for candidate, numbers in zip(self._hypothesis, values):
            if delays(candidate):
                commands = delayed_commands(
                    commands, numbers["time"] / self._sample_time, candidate.motors(self._robot)
                )
        return commands

    def _cut_off(self, torque: FloatArray, values: Values) -> FloatArray:
        """Saturate torques before they are delayed."""
        result = torque.copy()
        for candidate, saturated, numbers in zip(self._hypothesis, self.saturated, values, strict=True):
            if saturated:
                motor, effect = self._robot.joint_names.index(candidate.location), candidate.placed(numbers).effect
                assert isinstance(effect, AbstractCommandLaw)
                result[:, motor] = effect.cut_off(result[:, motor])
        return result

    def _late(self, values: Values, prescribed: Collection[int]) -> FloatArray:
        """Return the delay of the input of each motor [s], shape (M,); prescribed motions are never late."""
        late = np.array(np.broadcast_to(self._plant.delay, self._robot.n_motors))
        for candidate, numbers in zip(self._hypothesis, values):
            if delays(candidate):
                late[[motor for motor in candidate.motors(self._robot) if motor not in prescribed]] += numbers["time"]
        return late

    def _is_saturated_before(self, candidate: Candidate) -> bool:
        """Return whether a candidate saturates torques that another one delays."""
        if self._robot.commands == "position":  # the torque is made behind the delay
            return False
        return candidate.cuts_off and any(one.location in ("all", candidate.location) for one in self._delaying)
