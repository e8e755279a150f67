"""Short logs of the diagnosis experiment with further sensors, made from the true plant under the recorded commands."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.prediction.observer import observer_gain
from flexros.record.further_sensors import SENSOR_QUANTITIES, SensorRecord
from flexros.record.record import Record
from tests.gap.diagnosis_logs import MODEL, ROBOT, record_of

NOISE = {"link position": 1e-4, "joint torque": 0.05, "link speed": 0.01, "tool acceleration": 0.02}
OFFSET = 3.0
"""Offset of every sensor, over its noise."""


@dataclass(frozen=True, eq=False)
class Truth:
    """The true plant under the commands of a log: its predictor, the log that it yields, its states at the samples."""

    plant: Predictor
    record: Record
    states: np.ndarray


@cache
def truth_of(*effects: str, seed: int = 1) -> Truth:
    """Let the true plant run from rest under the commands of a log, without correction."""
    record = record_of(*effects, seed=seed)
    model = place_effects(ROBOT, [parse_effect(text, "test") for text in effects])
    plant = Predictor(model, (), Tolerance(), ROBOT.sample_time)
    gain = observer_gain(ROBOT, ROBOT.sample_time, 1e-3, ROBOT.encoder_noise)
    free = replace(gain, gain=np.zeros_like(gain.gain))
    rest = ROBOT.equilibrium(motor_position=np.zeros(ROBOT.n_motors))
    run = plant.predict(np.zeros((0, 1)), record, free, rest, from_rest=True, record_states=True)
    assert run.states is not None
    noise = ROBOT.encoder_noise * np.random.default_rng([seed, 1]).standard_normal(record.position.shape)
    return Truth(plant, replace(record, position=record.position - run.innovation[:, :, 0] + noise), run.states)


@cache
def sensed(*effects: str, sensors: tuple[str, ...] = ("link position",), seed: int = 1, every: int = 1) -> Record:
    """Add sensors to a log, each value with noise and an offset; `every` sample has one."""
    truth = truth_of(*effects, seed=seed)
    record = truth.record
    samples = np.arange(0, record.n_samples, every)
    wanted = [(name, 0) for name in sensors]
    outputs = truth.plant.sensor_outputs(wanted, np.zeros((0, 1)), record, truth.states[samples], samples)[:, :, 0]
    random, found = np.random.default_rng(seed), []
    for place, name in enumerate(sensors):
        of_tool = SENSOR_QUANTITIES[name].of_tool
        values = outputs[:, place] + NOISE[name] * (random.standard_normal(len(samples)) + OFFSET)
        motor = record.position[samples, 0] if name == "link position" else None
        found.append(
            SensorRecord(
                name,
                "x" if of_tool else "motor_1",
                0,
                SENSOR_QUANTITIES[name].units[0],
                samples * record.sample_time,
                values,
                motor,
            )
        )
    return replace(record, sensors=tuple(found))


def sensed_data(record: Record, model: RobotWithEffects = MODEL) -> FitData:
    """Weigh such a log."""
    return fit_data(record, model, DiagnosisSettings())
