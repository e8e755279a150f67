"""A fit that tests of its estimates share."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import CandidateFit
from tests.gap.diagnosis_logs import candidates_of, encoded, predictor_of


@pytest.fixture(name="fitted", scope="module")
def fitted_fixture() -> CandidateFit:
    """Coulomb friction by its logarithm, known to 10 %, and a stiffness to 0.02, and a tolerated parameter."""
    pair = [candidates_of()[name] for name in ("coulomb_friction@motor_1", "stiffness_error@body_2.rz")]
    predictor = predictor_of(*pair, tolerance=Tolerance(("body_1.rz.stiffness",), (0.02,)))
    theta = np.array([*encoded(pair[0], level=0.05), *encoded(pair[1], relative=-0.1), 0.5])
    scale = np.array([0.1, 0.02 / pair[1].free[0].high, 0.8])
    correlation = np.array([[1.0, 0.5, 0.2], [0.5, 1.0, 0.1], [0.2, 0.1, 1.0]])
    return CandidateFit(predictor, theta, 1.0, np.linalg.inv(correlation * np.outer(scale, scale)))
