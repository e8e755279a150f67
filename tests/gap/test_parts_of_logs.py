"""Parts of a log know when they began, so that what changes with time is predicted right in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import PlacedEffect, place_effects
from flexros.effects.friction.friction_drift import FrictionDrift
from flexros.gap.checked_log import checked_log
from flexros.gap.measure_gap import measure_gap
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

DRIFT = PlacedEffect(FrictionDrift(coulomb=0.6, viscous=0.0, time_constant=8.0), "motor_1")


def test_a_part_of_a_part_counts_its_time_from_the_begin_of_the_log() -> None:
    nothing = np.zeros((100, 1))
    record = Record("log", 0.01, nothing, nothing, np.ones(100, dtype=bool))
    assert record.begin == 0
    assert record.part(40, 100).part(10, 20).begin == pytest.approx(0.5)


@pytest.mark.slow
def test_drifting_friction_is_predicted_in_the_last_third_of_a_log() -> None:
    robot = load_robot("four_mass_linear")
    hidden = ["friction_drift@motor_1:coulomb=0.6,time_constant=8"]
    scenario = load_scenario("diagnosis").with_values({"diagnosis.length": 12.0, "plant.effects": hidden})
    whole = checked_log(closed_loop(Experiment.prepare(scenario)), robot, name="drift")
    last = whole.part(2 * whole.n_samples // 3, whole.n_samples)
    nominal, repaired = place_effects(robot, ()), place_effects(robot, [DRIFT], as_laws=True)
    closed = measure_gap(last, nominal, repaired=repaired).numbers.closed_fraction
    assert closed is not None
    assert closed > 0.99
    wrong = measure_gap(replace(last, begin=0.0), nominal, repaired=repaired).numbers.closed_fraction
    assert wrong is not None
    assert wrong < 0.9
