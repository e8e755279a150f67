"""The search, its covariance and what it says of a fit."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.axis import AxisStructure
from flexros.identify.axis.prediction_fit import AxisFit, fit_axis
from flexros.identify.axis.predictor import Predictor
from flexros.identify.axis.search_setup import bounds_around
from tests.identify.axis.recorded_axis import EFFECTS, TRUTH, axis_of, recorded_axis

pytestmark = pytest.mark.slow

STRUCTURE = AxisStructure(gear="linear", offset=True)
BEGIN = {name: TRUTH.get(name, 0.0) * (1.0 if name == "offset" else 1.3) for name in STRUCTURE.names}


def fit(seed: int, samples: int = 2500) -> AxisFit:
    record = axis_of(recorded_axis(EFFECTS[1:], seed=seed, samples=samples))
    predictor = Predictor(STRUCTURE, record, 0.02, 1)
    return fit_axis(predictor, record, BEGIN, bounds_around(STRUCTURE, BEGIN, {}, record))


@pytest.fixture(scope="module")
def fits() -> list[AxisFit]:
    return [fit(seed) for seed in range(8)]


def test_deviations_are_those_of_repeated_experiments(fits: list[AxisFit]) -> None:
    names = [name for name in STRUCTURE.names if name in TRUTH]
    errors = np.array([[(one.parameters[name] - TRUTH[name]) / one.deviation[name] for name in names] for one in fits])
    assert 0.6 < np.sqrt(np.mean(errors**2)) < 1.5
    assert np.mean(np.abs(errors) < 1.96) > 0.85


def test_offset_that_is_not_there_is_found_as_none(fits: list[AxisFit]) -> None:
    inside = [low <= 0 <= high for low, high in (one.interval("offset", 3.0) for one in fits)]
    assert all(inside)


def test_search_converges_and_leaves_white_errors(fits: list[AxisFit]) -> None:
    assert all(one.converged for one in fits)
    assert max(abs(one.whiteness) for one in fits) < 0.2
    assert all(one.quality.prediction > 99.9 for one in fits)


def test_bounds_hold() -> None:
    record = axis_of(recorded_axis(EFFECTS[1:], samples=1500))
    bounds = bounds_around(STRUCTURE, BEGIN, {"gear_stiffness": (7e4, 9e4)}, record)
    found = fit_axis(Predictor(STRUCTURE, record, 0.02, 1), record, BEGIN, bounds, rounds=1)
    assert found.parameters["gear_stiffness"] == pytest.approx(7e4)
