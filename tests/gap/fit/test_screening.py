"""The predicted gain of a candidate in addition to other effects, and its actual gain."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.least_squares import fit, initial_values, linearise
from flexros.gap.fit.screening import predicted_gains
from tests.gap.diagnosis_logs import candidates_of, encoded, predictor_of, search_of

TRUTH = ("coulomb_friction@motor_1:level=0.05", "stiffness_error@body_2.rz:relative=0.005")


@pytest.mark.slow
def test_the_missing_effect_gains_as_predicted_and_one_that_is_there_nothing() -> None:
    search = search_of(*TRUTH)
    friction, stiffness = (candidates_of(*TRUTH)[one.partition(":")[0]] for one in TRUTH)
    first = fit(predictor_of(friction), search.data, np.array(encoded(friction, level=0.05)))
    line = linearise(first.predictor, search.data, first.theta)

    def predicted(name: str) -> tuple[float, float]:
        predictor = predictor_of(candidates_of(*TRUTH)[name])
        ((gain, start),) = predicted_gains(
            predictor, search.data, initial_values(predictor), search.null_residual, [line]
        )
        return gain, float(start[0])

    both = predictor_of(friction, stiffness)
    gained = first.chi2 - fit(both, search.data, np.append(first.theta, 0.0)).chi2
    gain, start = predicted(stiffness.name)
    assert gained > 100
    assert gain == pytest.approx(gained, rel=0.3)
    assert start > 0
    assert predicted(friction.name)[0] < 0.1 * gained
