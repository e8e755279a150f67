"""The whole design: positions of E12 within their ranges, better than random ones, the same for the same seed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flexros.identify.design.candidates import candidate_positions
from flexros.identify.design.decay import decays_at
from flexros.identify.design.default_controller import default_controller
from flexros.identify.design.experiment_design import DesignSettings, ExperimentDesign, design_experiment
from flexros.identify.excitation.multisine import Multisine
from flexros.identify.experiment.specification import IdentificationSpecification
from flexros.robot import load_robot

pytestmark = pytest.mark.slow

ROBOT = load_robot("e12")
NAMES = tuple(name for name in ROBOT.parameters if name.endswith((".stiffness", ".damping")))
RANGES = [[-0.5, 0.5], [-1.5, 1.5]]


@cache
def designed(**settings: object) -> ExperimentDesign:
    specification = IdentificationSpecification(positions=((0.0, 0.3),), excitation=Multisine(highest=30.0))
    law = default_controller(ROBOT, ROBOT.sample_time)
    wanted = DesignSettings(candidates=100, **{"positions": 4, **settings})
    return design_experiment(ROBOT, NAMES, specification, law, ROBOT.sample_time, wanted, RANGES)


def test_positions_differ_lie_within_their_ranges_and_repeat() -> None:
    design = designed()
    assert design.positions.shape == (4, 2)
    assert len(np.unique(design.positions, axis=0)) == 4
    assert np.all(np.abs(design.positions) <= [0.5, 1.5])
    assert design.counts.tolist() == [1, 1, 1, 1]
    assert np.array_equal(design.positions, designed.__wrapped__().positions)
    assert not np.array_equal(design.positions, designed(seed=2).positions)


def test_design_beats_random_positions_and_is_optimal_before_rounding() -> None:
    design = designed()
    assert design.design.gap < 1e-6
    assert np.median(design.gain.random_efficiency) < design.gain.efficiency <= 1 + 1e-9


def test_information_is_that_of_the_chosen_positions() -> None:
    design = designed(most=None, positions=6)
    assert design.counts.sum() == 6
    deviation = np.sqrt(np.diag(np.linalg.inv(design.information + design.design.prior * 6)))
    assert design.gain.deviation == pytest.approx(deviation)


def test_distortions_make_the_prediction_less_certain() -> None:
    assert np.all(designed(distortion=0.05).gain.deviation > 3 * designed().gain.deviation)


def test_progress_counts_the_candidates() -> None:
    told: list[tuple[str, int, int]] = []
    specification = IdentificationSpecification(positions=((0.0, 0.3),))
    law = default_controller(ROBOT, ROBOT.sample_time)
    settings = DesignSettings(positions=3, candidates=40)
    design_experiment(
        ROBOT, NAMES, specification, law, ROBOT.sample_time, settings, progress=lambda *each: told.append(each)
    )
    assert ("candidate positions", 40, 40) in told
    assert ("settling of the positions", 40, 40) in told
    what, done, whole = told[-1]
    assert what == "information of the positions"
    assert done == whole <= 40


def test_positions_where_the_loop_settles_slowly_are_left_out() -> None:
    """With short transient periods none settles: the fastest tenth is kept."""
    specification = IdentificationSpecification(
        positions=((0.0, 0.3),), excitation=Multisine(highest=30.0), transient_periods=0
    )
    law = default_controller(ROBOT, ROBOT.sample_time)
    settings = DesignSettings(positions=4, candidates=100)
    design = design_experiment(ROBOT, NAMES, specification, law, ROBOT.sample_time, settings, RANGES)
    assert design.candidates.refused["the loop settles too slowly"] == 90
    kept = decays_at(ROBOT, design.candidates.motor_positions, law, ROBOT.sample_time)
    everything = candidate_positions(ROBOT, 100, RANGES, 1)
    assert np.min(kept) >= np.quantile(decays_at(ROBOT, everything.motor_positions, law, ROBOT.sample_time), 0.9)
