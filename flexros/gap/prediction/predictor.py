"""Predictors of a log: the robot with the effects of a hypothesis, corrected from the log with a constant gain."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.sensor import AbstractSensor
from flexros.errors import InputError
from flexros.gap.candidates.candidate import own_numbers
from flexros.gap.prediction.compiled_plant import LANES, compiled_plant, delays, is_law
from flexros.gap.prediction.plant_inputs import ParameterSet, PlantInputs

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.compile.loop.prediction import LoopPrediction
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.prediction.compiled_plant import CompiledPlant
    from flexros.prediction.observer import ObserverGain
    from flexros.record.record import Record

KEPT = 64
"""Sets of parameters whose numbers in the plant are kept [1] (chosen): a step of a fit asks for each several times."""
MOST_LOGARITHM = 50.0
"""Largest logarithm of a factor on a parameter of the robot, for fits that diverge [1] (chosen)."""


@dataclass(frozen=True, eq=False)
class PredictedAhead:
    """Predictions without correction, from several samples of a log.

    Attributes:
        positions: Motor positions at the horizon, without noise [rad or m], shape (n_starts, M).
        states: States at the last samples up to the horizon, shape (n_starts, last, n_states); None if not requested.
    """

    positions: FloatArray
    states: FloatArray | None


class Predictor:
    """Predicts logs under one hypothesis.

    The fitted parameters are those of the candidates, one after the other, then the deviations of the tolerated
    parameters of the robot in standard deviations, along the directions of the tolerance: a parameter is its nominal
    value times exp(deviation times tolerance).

    Args:
        model: The nominal model: robot and laws of known effects.
        hypothesis: Effects in addition to these.
        tolerance: Parameters of the robot that may deviate.
        sample_time: Time between two samples [s].
        measured_torque: Whether the torques of the log were measured at the motors, after the nominal delay.
        plant: The same model compiled with more candidates; it is used where it covers the hypothesis.
    """

    def __init__(
        self,
        model: RobotWithEffects,
        hypothesis: Hypothesis,
        tolerance: Tolerance,
        sample_time: float,
        *,
        measured_torque: bool = False,
        plant: CompiledPlant | None = None,
    ) -> None:
        self.robot = model.robot
        self.hypothesis, self.tolerance = hypothesis, tolerance
        if tolerance.directions is not None:  # else the prior takes the deviations of these numbers back by itself
            self.tolerance = tolerance.known(own_numbers(hypothesis, model.robot))
        self.sample_time = sample_time
        if plant is None or not plant.covers(hypothesis):
            plant = compiled_plant(model, hypothesis, tolerance.names, sample_time, measured_torque=measured_torque)
        self.plant, self.model, self.loop = plant, plant.model, plant.loop
        self._parameters = [(candidate, one) for candidate in hypothesis for one in candidate.free]
        self._nominal = {name: self.robot.parameters[name].value for name in plant.robot_names}
        self._inputs = PlantInputs(plant, hypothesis, sample_time)
        self._places = [plant.place(one) if is_law(one) else None for one in hypothesis]
        self._sets: dict[bytes, ParameterSet] = {}

    @cached_property
    def coarse(self) -> Predictor | None:
        """The same predictor with few long steps, for changes of a prediction; None where that saves little."""
        loop = self.plant.coarse_loop
        if loop is None:
            return None
        twin = copy(self)
        twin.loop = loop
        return twin

    def with_tolerance(self, tolerance: Tolerance) -> Predictor:
        """Return the same predictor with its tolerated numbers along other directions, or searched farther.

        Args:
            tolerance: The tolerance, of the same numbers.
        """
        twin = copy(self)
        twin.__dict__.pop("coarse", None)
        twin.tolerance, twin._sets = tolerance, {}
        return twin

    @property
    def n_effect(self) -> int:
        """Number of fitted parameters of the candidates."""
        return len(self._parameters)

    @property
    def n_fitted(self) -> int:
        """Number of all fitted parameters, including tolerated deviations."""
        return len(self._parameters) + self.tolerance.n_free

    @property
    def jumps(self) -> bool:
        """Whether predictions may jump where parameters change a little, see `AbstractEffect.jumps`."""
        return any(one.effect.jumps for one in self.hypothesis) or any(law.effect.jumps for law in self.model.laws)

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Bounds of the fitted parameters, encoded, shape (n_fitted,) each."""
        farthest = self.tolerance.farthest
        pairs = [one.bounds for _, one in self._parameters] + [(-farthest, farthest)] * self.tolerance.n_free
        table = np.array(pairs, dtype=float).reshape(-1, 2)
        return table[:, 0], table[:, 1]

    @property
    def fineness(self) -> FloatArray:
        """Step of the differences that make the derivatives, over the usual one [1], shape (n_fitted,)."""
        return np.array([*(one.fine for _, one in self._parameters), *([1.0] * self.tolerance.n_free)])

    def values(self, theta: FloatArray) -> list[dict[str, float]]:
        """Return the values of the free parameters of every candidate [their units].

        Args:
            theta: Encoded parameters, shape (n_fitted,).
        """
        result: list[dict[str, float]] = [{} for _ in self.hypothesis]
        index = {id(candidate): row for row, candidate in enumerate(self.hypothesis)}
        for encoded, (candidate, parameter) in zip(theta, self._parameters):
            result[index[id(candidate)]][parameter.name] = float(parameter.decode(np.asarray(encoded)))
        return result

    def slopes(self, theta: FloatArray) -> FloatArray:
        """Return the derivatives of the values of all free parameters to the encoded ones, shape (n_effect,).

        Args:
            theta: Encoded parameters, shape (n_fitted,).
        """
        pairs = zip(theta, self._parameters)
        return np.array([one.high if one.signed else float(np.exp(number)) for number, (_, one) in pairs])

    def behind_encoders(self, start: FloatArray, thetas: FloatArray) -> FloatArray:
        """Move a state of the robot at measured positions to those of hypotheses whose encoders have another zero.

        Args:
            start: State at the measured positions, shape (2 n_coordinates,), or (2 n_coordinates, sets).
            thetas: Encoded parameters, shape (n_fitted, sets).

        Returns:
            States of the same shape, or of all sets where a hypothesis has such an encoder.
        """
        offsets = [self.encoder_offsets(theta) for theta in thetas.T]
        if not np.any(offsets):
            return start
        moved = np.repeat(start[:, None], len(offsets), axis=1) if start.ndim == 1 else start.copy()
        for motor, rows in enumerate(zip(self.robot.motor_rows, self.robot.gear_rows, strict=True)):
            moved[sorted(set(rows))] -= [offset[motor] for offset in offsets]
        return moved

    def encoder_offsets(self, theta: FloatArray) -> FloatArray:
        """Return by how much encoders are off wherever their motors are [rad or m], shape (M,).

        Args:
            theta: Encoded parameters, shape (n_fitted,).
        """
        offsets = np.zeros(self.robot.n_motors)
        for candidate, sizes in zip(self.hypothesis, self._set(theta).values, strict=True):
            if issubclass(candidate.effect, AbstractSensor):
                effect = candidate.placed(sizes).effect
                assert isinstance(effect, AbstractSensor)
                offsets[candidate.motors(self.robot)] += effect.constant_error()
        return offsets

    def predict(
        self,
        thetas: FloatArray,
        record: Record,
        gain: ObserverGain,
        start: FloatArray,
        *,
        from_rest: bool = False,
        pose_samples: IntArray | None = None,
        record_states: bool = False,
    ) -> LoopPrediction:
        """Predict a log with up to `LANES` parameter sets in parallel.

        Args:
            thetas: Encoded parameters, shape (n_fitted, sets); the last set fills unused lanes.
            record: The log.
            gain: Gain of the predictor for the states of the robot; it also corrects states of effects that hold a
                deflection.
            start: State of the robot before the first sample, shape (2 n_coordinates,), or (2 n_coordinates, sets) for
                one of each set.
            from_rest: Whether every parameter set begins in its own equilibrium at these motor positions.
            pose_samples: Samples whose tool pose is recorded, increasing, shape (m,); None for none.
            record_states: Whether to record the states.

        Returns:
            Prediction errors and the requested records, with a last axis of lanes.
        """
        sets = [self._set(theta) for theta in np.asarray(thetas).T]
        columns = [one.column for one in sets]
        states = [start] if start.ndim == 1 else list(start.T)
        plants = []
        for lane in range(max(len(sets), len(states))):
            column, state = columns[min(lane, len(sets) - 1)], states[min(lane, len(states) - 1)]
            near = self._rest(state, column) if from_rest else state
            plants.append(self.model.start(near, record.driving[0], column, time=record.begin))
        driving = self._inputs.driving(record, sets)
        parts = self.plant.parts
        prediction = self.loop.run(
            _in_all_lanes(plants),
            _in_all_lanes(columns),
            self.model.corrections(gain.gain),
            driving if driving.ndim == 2 else _in_all_lanes(list(np.moveaxis(driving, -1, 0))),
            _at_first_parts(record.position, parts),
            _at_first_parts(record.correcting.astype(float), parts),
            pose_samples=None if pose_samples is None else parts * pose_samples,
            record_states=record_states,
        )
        return prediction if parts == 1 else _at_samples(prediction, parts)

    def ahead(
        self,
        theta: FloatArray,
        record: Record,
        states: FloatArray,
        starts: IntArray,
        horizon: int,
        *,
        last: int = 0,
    ) -> PredictedAhead:
        """Predict without correction, from corrected states.

        Args:
            theta: Encoded parameters, shape (n_fitted,).
            record: The log.
            states: Corrected states of all samples, shape (n, n_states).
            starts: Samples from which to predict, each at least the delay from the first, shape (n_starts,).
            horizon: Prediction horizon [samples].
            last: Number of samples up to the horizon whose states are recorded, at most horizon + 1.
        """
        own, parts = self._set(theta), self.plant.parts
        column = np.repeat(own.column[:, None], LANES, axis=1)
        torque = self._inputs.driving(record, [own])
        torque = torque if torque.ndim == 2 else torque[:, :, 0]
        length = parts * horizon + 1
        nothing = np.zeros((length, self.robot.n_motors))
        gain = np.zeros((self.loop.sizes.state, self.robot.n_motors))
        past = np.arange(1, self.loop.line_length + 1)
        runs, ends = [], []
        for first in range(0, len(starts), LANES):
            group = starts[first : first + LANES]
            lanes = np.concatenate([group, np.repeat(group[-1:], LANES - len(group))])
            windows = np.stack([torque[parts * start : parts * start + length] for start in lanes], axis=-1)
            before = np.stack([torque[start - past] for start in lanes], axis=-1)
            one = self.loop.run(
                states[lanes].T,
                column,
                gain,
                windows,
                nothing,
                np.ones(length),
                past=before,
                record_states=last > 0,
            )
            runs.append(-one.innovation[-1].T[: len(group)])
            if one.states is not None:
                final = one.states[::parts][horizon + 1 - last :]
                ends.append(final[:, :, : len(group)].transpose(2, 0, 1))
        return PredictedAhead(np.concatenate(runs), np.concatenate(ends) if last else None)

    def sensor_outputs(
        self,
        wanted: Sequence[tuple[str, int]],
        thetas: FloatArray,
        record: Record,
        states: FloatArray,
        samples: IntArray,
    ) -> FloatArray:
        """Return what further sensors show without noise, at samples of a log.

        At a sample, where the held torque changes, the mean of the torques before and after it acts.

        Args:
            wanted: Quantity and number of the motor or of the axis, of each sensor.
            thetas: Encoded parameters, shape (n_fitted, sets); the last set fills unused lanes.
            record: The log.
            states: States of the samples, shape (m, n_states, lanes).
            samples: The samples, shape (m,).

        Returns:
            Outputs, shape (m, n_sensors, lanes).
        """
        sets = [self._set(theta) for theta in np.asarray(thetas).T]
        function, driven = self.plant.sensors(wanted)
        acting = self._inputs.acting(record, sets, samples) if driven else np.zeros((1, 1, 1))
        acting = acting if acting.shape[-1] == 1 else _in_all_lanes(list(np.moveaxis(acting, -1, 0)))
        return function(states, acting, _in_all_lanes([one.column for one in sets]))

    def numbers(self, theta: FloatArray) -> dict[str, float]:
        """Return the numbers of the robot that the hypothesis or its tolerance may change, by name [SI].

        Args:
            theta: Encoded parameters, shape (n_fitted,).
        """
        return dict(zip(self.plant.robot_names, self._set(theta).column.tolist()))

    def _set(self, theta: FloatArray) -> ParameterSet:
        """Decode one set of fitted parameters, or return what is known of it."""
        key = theta.tobytes()
        found = self._sets.get(key)
        if found is None:
            if len(self._sets) >= KEPT:
                self._sets.clear()
            values = self.values(theta)
            found = self._sets[key] = ParameterSet(values, self._column(theta, values))
        return found

    def _column(self, theta: FloatArray, values: Sequence[Mapping[str, float]]) -> FloatArray:
        """Compute the parameters of the plant from a set and the values that it gives to the candidates."""
        robot = dict(self._nominal)
        logarithms = np.clip(self.tolerance.logarithms(theta[self.n_effect :]), -MOST_LOGARITHM, MOST_LOGARITHM)
        for name, factor in zip(self.tolerance.names, np.exp(logarithms).tolist(), strict=True):
            robot[name] *= factor
        acting: dict[int, AbstractLaw] = {}
        for candidate, place, saturated, numbers in zip(
            self.hypothesis, self._places, self._inputs.saturated, values, strict=True
        ):
            effect = candidate.placed(numbers).effect
            if place is not None:
                assert isinstance(effect, AbstractLaw)
                if not saturated:
                    acting[place] = effect.acting
            elif not delays(candidate):
                assert isinstance(effect, AbstractChangedValues)
                for name, value in effect.values(self.robot, candidate.location).items():
                    robot[name] += value - self._nominal[name]
        column = np.array([*robot.values(), *self.plant.law_parameters(acting)])
        column.flags.writeable = False
        return column

    def _rest(self, near: FloatArray, column: FloatArray) -> FloatArray:
        """Find the equilibrium of the plant near a state; return that state where there is none."""
        try:
            return self.model.rest(near, column).state
        except InputError:
            return near


def _in_all_lanes(sets: Sequence[FloatArray]) -> FloatArray:
    """Stack what belongs to each set along a last axis of lanes, the last one in all that are left."""
    return np.stack([sets[min(lane, len(sets) - 1)] for lane in range(LANES)], axis=-1)


def _at_first_parts(values: FloatArray, parts: int) -> FloatArray:
    """Put values of samples at the first part of each, and zeros, which correct nothing, at the others."""
    if parts == 1:
        return values
    spread = np.zeros((parts * len(values), *values.shape[1:]))
    spread[::parts] = values
    return spread


def _at_samples(prediction: LoopPrediction, parts: int) -> LoopPrediction:
    """Return what belongs to the samples of a prediction of several parts of each."""
    states, diverged = prediction.states, prediction.diverged
    return replace(
        prediction,
        innovation=np.ascontiguousarray(prediction.innovation[::parts]),
        states=None if states is None else np.ascontiguousarray(states[::parts]),
        diverged=np.where(diverged < 0, diverged, diverged // parts),
    )
