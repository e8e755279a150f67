"""Predictors of a log: the robot with the effects of a hypothesis inside, tied to the log by a constant gain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.prediction_loop import Prediction, PredictionLoop
from flexros.effects import place_effects
from flexros.effects.delay import Delay
from flexros.effects.model_change import AbstractChangedValues
from flexros.effects.motor_law import AbstractMotorLaw
from flexros.simulate.loop import feed_through
from flexros.simulate.plant_model import PlantModel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.gap.gain import ObserverGain
    from flexros.gap.hypothesis import Hypothesis, Suspect
    from flexros.gap.record import GapRecord
    from flexros.robot import Robot

LANES = 8
"""Parameter sets that are predicted side by side [1]."""
LONGEST_STEP = 5e-4
"""Longest integration step [s]; logs of lower rates take several steps per sample."""


@dataclass(frozen=True)
class Tolerance:
    """Numbers of the nominal model that are known with a tolerance only.

    Attributes:
        names: Parameters of the robot.
        deviations: One standard deviation each, relative to the value, shape (n,).
    """

    names: tuple[str, ...] = ()
    deviations: tuple[float, ...] = ()


class Predictor:
    """Predicts logs under one hypothesis.

    The numbers that are fitted are those of the suspects, one after the other, then the deviations of the tolerated
    numbers of the robot in standard deviations.

    Args:
        robot: The nominal robot.
        hypothesis: Effects that are there.
        tolerance: Numbers of the robot that may deviate.
        sample_time: Time between two samples [s].
        measured_torque: Whether the torques of the log were measured at the motors, behind the nominal delay.
    """

    def __init__(
        self,
        robot: Robot,
        hypothesis: Hypothesis,
        tolerance: Tolerance,
        sample_time: float,
        *,
        measured_torque: bool = False,
    ) -> None:
        self.robot, self.hypothesis, self.tolerance = robot, hypothesis, tolerance
        self.sample_time = sample_time
        self._parameters = [(suspect, one) for suspect in hypothesis for one in suspect.free]
        self._laws = place_effects(robot, [one.typical() for one in hypothesis if _is_law(one)]).laws
        self._law_names = [name for law in self._laws for name in law.parameters]
        self._values = [one for one in hypothesis if issubclass(one.effect, AbstractChangedValues) and not _delays(one)]
        changed = [name for one in self._values for name in _changed(robot, one)]
        self._robot_names = sorted({*changed, *tolerance.names})
        self.model = PlantModel(robot, self._laws, [*self._robot_names, *self._law_names])
        self.loop = PredictionLoop(
            self.model.functions(feed_through(robot.n_motors)),
            sample_time=sample_time,
            delay=0.0 if measured_torque else robot.delay,
            substeps=max(1, round(sample_time / LONGEST_STEP)),
            lanes=LANES,
        )

    @property
    def n_effect(self) -> int:
        """Number of fitted numbers of the suspects."""
        return len(self._parameters)

    @property
    def n_fitted(self) -> int:
        """Number of all fitted numbers, tolerated deviations included."""
        return len(self._parameters) + len(self.tolerance.names)

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Smallest and largest of the numbers that the fit moves, shape (n_fitted,) each."""
        pairs = [one.bounds for _, one in self._parameters] + [(-10.0, 10.0)] * len(self.tolerance.names)
        table = np.array(pairs, dtype=float).reshape(-1, 2)
        return table[:, 0], table[:, 1]

    def values(self, theta: FloatArray) -> list[dict[str, float]]:
        """Return the values of the free parameters of every suspect [their units].

        Args:
            theta: Numbers of the fit, shape (n_fitted,).
        """
        result: list[dict[str, float]] = [{} for _ in self.hypothesis]
        places = {id(suspect): place for place, suspect in enumerate(self.hypothesis)}
        for number, (suspect, one) in zip(theta, self._parameters):
            result[places[id(suspect)]][one.name] = float(one.decode(np.asarray(number)))
        return result

    def predict(
        self,
        thetas: FloatArray,
        record: GapRecord,
        gain: ObserverGain,
        start: FloatArray,
        *,
        record_pose: bool = False,
        record_states: bool = False,
    ) -> Prediction:
        """Predict a log with up to `LANES` sets of numbers side by side.

        Args:
            thetas: Numbers of the fit, shape (n_fitted, sets); the last set fills lanes that are left.
            record: The log.
            gain: Gain of the predictor for the states of the robot; effects' own states are not corrected.
            start: State of the robot before the first sample, shape (2 n_coordinates,).
            record_pose: Whether to record the tool pose.
            record_states: Whether to record the states.

        Returns:
            Prediction errors and what else was asked for, with a last axis of lanes.
        """
        sets = [np.asarray(thetas)[:, min(lane, np.shape(thetas)[1] - 1)] for lane in range(LANES)]
        columns = np.stack([self._column(theta) for theta in sets], axis=-1)
        plant = self.model.start(start)
        K = np.zeros((len(plant), self.robot.n_motors))
        K[: len(gain.gain)] = gain.gain
        return self.loop.run(
            plant,
            columns,
            K,
            self._torque(record.torque, sets),
            record.position,
            record.valid.astype(float),
            record_pose=record_pose,
            record_states=record_states,
        )

    def _column(self, theta: FloatArray) -> FloatArray:
        """Return the parameters of the plant for one set of numbers."""
        values = self.values(theta)
        robot = dict.fromkeys(self._robot_names, 1.0)
        for name, sd, deviation in zip(self.tolerance.names, self.tolerance.deviations, theta[self.n_effect :]):
            robot[name] *= max(1.0 + sd * float(deviation), 0.05)
        nominal = {name: self.robot.parameters[name].value for name in robot}
        robot = {name: factor * nominal[name] for name, factor in robot.items()}
        laws: list[float] = []
        for suspect, numbers in zip(self.hypothesis, values):
            placed = suspect.placed(numbers)
            if suspect in self._values:
                assert isinstance(placed.effect, AbstractChangedValues)
                for name, value in placed.effect.values(self.robot, placed.location).items():
                    robot[name] += value - nominal[name]
            elif _is_law(suspect):
                assert isinstance(placed.effect, AbstractMotorLaw)
                laws += placed.effect.numbers.values()
        return np.array([*robot.values(), *laws])

    def _torque(self, torque: FloatArray, sets: Sequence[FloatArray]) -> FloatArray:
        """Delay the recorded torques where that is part of the hypothesis."""
        if not any(_delays(suspect) for suspect in self.hypothesis):
            return torque
        lanes = []
        for theta in sets:
            shifted = torque
            for suspect, numbers in zip(self.hypothesis, self.values(theta)):
                if _delays(suspect):
                    motors = [
                        motor for motor, name in enumerate(self.robot.joint_names) if suspect.location in ("all", name)
                    ]
                    shifted = delayed(shifted, numbers["time"] / self.sample_time, motors)
            lanes.append(shifted)
        return np.stack(lanes, axis=-1)


def delayed(torque: FloatArray, samples: float, motors: Sequence[int]) -> FloatArray:
    """Delay torques by any number of samples; a sample gets the mean of what acts in it.

    Args:
        torque: Torques, each held from its sample to the next [Nm or N], shape (n, M).
        samples: The delay [samples], zero or more.
        motors: Numbers of the motors whose torques are delayed (0-based).

    Returns:
        Delayed torques, shape (n, M).
    """
    whole = int(np.floor(samples))
    fraction = samples - whole
    rows = np.arange(len(torque)) - whole
    result = np.array(torque)
    for motor in motors:
        one = torque[:, motor]
        result[:, motor] = (1 - fraction) * one[np.maximum(rows, 0)] + fraction * one[np.maximum(rows - 1, 0)]
    return result


def _is_law(suspect: Suspect) -> bool:
    return issubclass(suspect.effect, AbstractMotorLaw)


def _delays(suspect: Suspect) -> bool:
    return suspect.effect is Delay


def _changed(robot: Robot, suspect: Suspect) -> tuple[str, ...]:
    """Name the numbers of the robot that an effect changes."""
    placed = suspect.typical()
    assert isinstance(placed.effect, AbstractChangedValues)
    return tuple(placed.effect.values(robot, suspect.location))
