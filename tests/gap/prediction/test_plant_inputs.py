"""Inputs of a plant at single samples."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

from flexros.gap.prediction.plant_inputs import ParameterSet, PlantInputs
from tests.gap.diagnosis_logs import ROBOT, record_of

if TYPE_CHECKING:
    from flexros.gap.prediction.compiled_plant import CompiledPlant

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("delay", "sample_time", "late"),
    [
        (0.0, 5e-4, 0.5),  # between the torque that ends at a sample and that which begins there
        (6e-4, 2e-4, 3.5),  # 2.9999999999999996 samples
        (1.2e-3, 2e-4, 6.5),  # 5.999999999999999 samples
        (0.0035, 5e-4, 7.5),
        (7e-4, 5e-4, 2.0),
    ],
)
def test_a_delay_of_whole_samples_is_one_in_spite_of_round_off(delay: float, sample_time: float, late: float) -> None:
    plant = cast("CompiledPlant", SimpleNamespace(robot=ROBOT, delay=delay, parts=1))
    record = record_of().part(0, 50)
    record = replace(record, torque=np.arange(50.0)[:, None])
    samples = np.array([20, 40])
    acting = PlantInputs(plant, (), sample_time).acting(record, [ParameterSet((), np.zeros(0))], samples)
    np.testing.assert_array_equal(acting[:, 0, 0], samples - late)
