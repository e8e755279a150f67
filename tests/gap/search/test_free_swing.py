"""A swing with the drives off: the weight of the arm drives it, and its friction is found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.gap.candidates.scales import SMALLEST, scales_of_motors
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.record.record import Record
from flexros.simulate.plant import Plant
from tests.gap.diagnosis_logs import settings_of
from tests.gap.servo_logs import NOISE, ONE, servo_robot
from tests.gap.servo_logs import T as SAMPLE

ROBOT = servo_robot(servo=False)
COMPETING = "coulomb_friction", "viscous_friction", "presliding_friction", "gravity_error", "motor_inertia_error"


def swing(*effects: str, samples: int = 2000) -> Record:
    """A log of a link that falls from 1.2 rad above its lowest position, without torque."""
    placed = place_effects(ROBOT, [parse_effect(one, "test") for one in effects])
    still = np.zeros(1)
    start = placed.robot.equilibrium(motor_position=[1.2])
    plant = Plant(placed.robot, SAMPLE, start, laws=placed.laws, torque=still, substeps=8)
    position = np.empty((samples, 1))
    for k in range(samples):
        position[k] = plant.measure()
        plant.advance(still)
    position += NOISE * np.random.default_rng(0).normal(size=position.shape)
    stamp = stamps_ns(samples, SAMPLE)
    log = Log(JointSeries(stamp, ONE, position=position), JointSeries(stamp, ONE, effort=np.zeros((samples, 1))))
    return replace(checked_log(log, ROBOT, name="log"), imported=True)


def test_the_weight_scales_the_torques_of_a_motor_without_any() -> None:
    record = swing()
    assert scales_of_motors(ROBOT, record).of("torque", "motor_1") == pytest.approx(1.5 * 9.81 * 0.2, rel=0.1)
    at_rest = replace(record, position=np.zeros_like(record.position))
    assert scales_of_motors(ROBOT, at_rest).of("torque", "motor_1") == SMALLEST


@pytest.mark.slow
def test_dry_friction_of_a_swing_is_found() -> None:
    result = diagnose(swing("coulomb_friction@motor_1:level=0.05"), ROBOT, settings=settings_of(*COMPETING))
    (cause,) = result.diagnosis.causes
    assert cause.effect == "coulomb_friction"
    assert cause.parameters["level"].value == pytest.approx(0.05, rel=0.02)
