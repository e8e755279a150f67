"""Errors of the initial state: their effect on weighted prediction errors is projected out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.residuals.fit_data import FitData
from tests.gap.diagnosis_logs import candidates_of, data_of, predictor_of

NOTHING = np.zeros((0, 1))


def residual_of(data: FitData) -> np.ndarray:
    """Weigh the prediction errors of the nominal model."""
    return data.residuals(predictor_of(), NOTHING)[:, 0]


@pytest.mark.parametrize("tool", [False, True])
def test_initial_state_errors_are_projected_out(tool: bool) -> None:
    """Each state by five times its error in a settled predictor; directions that hardly show may remain."""
    data = data_of(tool=tool)
    moved = replace(data, initial_state=data.initial_state + 5 * np.sqrt(np.diag(data.gain.error)), from_rest=False)
    plain = replace(moved, initial_state=data.initial_state)
    untreated = [residual_of(replace(each, initial_state_errors=None)) for each in (plain, moved)]
    assert np.linalg.norm(untreated[1] - untreated[0]) > 5
    assert np.linalg.norm(residual_of(moved) - residual_of(plain)) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 6))
def test_the_first_samples_of_a_log_from_rest_are_as_noisy_as_all_others(seed: int) -> None:
    data = data_of(seed=seed)
    assert data.initial_state_errors is not None
    first = data.gain.settling
    early = residual_of(data)[:first]
    values = first - data.initial_state_errors.number
    assert np.sum(early**2) / values == pytest.approx(1.0, abs=4 * np.sqrt(2 / values))


@pytest.mark.parametrize("tool", [False, True])
def test_the_directions_are_orthonormal_and_at_most_as_many_as_states(tool: bool) -> None:
    data = data_of(tool=tool)
    found = data.initial_state_errors
    assert found is not None
    basis = np.vstack([found.motors.reshape(-1, found.number), found.others])
    np.testing.assert_allclose(basis.T @ basis, np.eye(found.number), atol=1e-12)
    assert 2 <= found.number <= len(data.initial_state)


@pytest.mark.slow
def test_a_gap_that_shows_only_while_the_initial_state_decays_is_seen() -> None:
    """Friction shows in the first samples, and explains them."""
    friction = "coulomb_friction@motor_1:level=0.05"
    data = data_of(friction)
    assert data.initial_state_errors is not None
    first = data.gain.settling
    early = residual_of(data)[:first]
    assert np.sum(early**2) / first > 2.0
    candidate = candidates_of(friction)["coulomb_friction@motor_1"]
    explained = data.residuals(predictor_of(candidate), np.array([[candidate.free[0].encode(0.05)]]))[:first, 0]
    assert np.sum(explained**2) / first == pytest.approx(1.0, abs=4 * np.sqrt(2 / first))
