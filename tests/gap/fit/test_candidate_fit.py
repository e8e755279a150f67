"""Which of several fits is the best."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.candidate_fit import CandidateFit, best_of, best_of_each
from tests.gap.diagnosis_logs import candidates_of, predictor_of

pytestmark = pytest.mark.slow


def test_the_best_fit_has_the_smallest_sum() -> None:
    fits = [CandidateFit(predictor_of(), np.zeros(0), chi2) for chi2 in (3.0, 1.0, 2.0)]
    assert best_of(fits) is fits[1]


def test_of_one_set_of_effects_the_best_fit_is_kept() -> None:
    friction, soft = (candidates_of()[name] for name in ("coulomb_friction@motor_1", "stiffness_error@body_2.rz"))

    def fitted(chi2: float, *hypothesis: str) -> CandidateFit:
        predictor = predictor_of(*(candidates_of()[name] for name in hypothesis))
        return CandidateFit(predictor, np.zeros(predictor.n_fitted), chi2)

    fits = [fitted(3.0, friction.name, soft.name), fitted(1.0, soft.name, friction.name), fitted(2.0, soft.name)]
    assert best_of_each(fits) == [fits[1], fits[2]]
