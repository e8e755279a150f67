"""Sums of squares of many sets of parameters."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.sum_of_squares import chi2_of
from tests.gap.diagnosis_logs import candidates_of, data_of, predictor_of

pytestmark = pytest.mark.slow


def test_sums_of_many_sets_are_those_of_each() -> None:
    candidate = candidates_of()["coulomb_friction@motor_1"]
    thetas = np.log(np.geomspace(1e-3, 0.1, 11))[None]
    sums = chi2_of(predictor_of(candidate), data_of(), thetas)
    assert sums.shape == (11,)
    assert sums[10] == pytest.approx(float(chi2_of(predictor_of(candidate), data_of(), thetas[:, 10:])[0]))
