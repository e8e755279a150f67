"""How late torques act, by the regression of all torques."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.torques.delay import torque_delay
from flexros.gap.fit.torques.unknown_numbers import unknown_numbers
from flexros.gap.settings import TorqueStartSettings
from flexros.record.record import Record
from tests.gap.rigid_arm import INERTIA, T, arm, record_of_arm

MODEL = RobotWithEffects(arm(), ())


def late(samples: int) -> Record:
    """Return a log whose torques are noted some samples before they act."""
    record = record_of_arm(imported=True)
    return replace(record, torque=np.vstack([record.torque[samples:], np.repeat(record.torque[-1:], samples, axis=0)]))


@pytest.mark.parametrize("samples", [0, 2, 4])
def test_torques_are_as_late_as_the_regression_leaves_least(samples: int) -> None:
    assert torque_delay(late(samples), MODEL, tolerance_of(arm(), {})) == pytest.approx(samples * T)


def test_a_delay_that_is_not_clear_is_none() -> None:
    assert torque_delay(late(2), MODEL, tolerance_of(arm(), {}), TorqueStartSettings(late=20.0)) == 0.0


def test_no_delay_is_sought_in_logs_of_this_program() -> None:
    assert torque_delay(replace(late(2), simulated=True), MODEL, tolerance_of(arm(), {})) == 0.0


def test_rotors_are_estimated_with_torques_as_late_as_they_act() -> None:
    unknown = unknown_numbers(late(4), MODEL, tolerance_of(arm(), {}))
    np.testing.assert_allclose(list(unknown.inertias.values()), INERTIA, rtol=0.05)
