"""Changes of the prediction errors by a candidate."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from flexros.gap.fit.directions import directions_of, diverged
from flexros.gap.prediction.compiled_plant import LANES


def test_initial_values_that_were_not_predicted_are_left_out() -> None:
    predictor: Any = SimpleNamespace(n_effect=1, hypothesis=("candidate",))
    data: Any = SimpleNamespace(residuals=lambda predictor, thetas: np.zeros((5, thetas.shape[1])))
    found = directions_of(
        predictor, data, np.zeros(0), np.arange(20.0)[None], np.zeros(5), np.arange(5), stop=lambda: True
    )
    assert found.starts.shape == (1, LANES)
    assert found.changes.shape == (5, LANES)
    assert found.usable.shape == (LANES,)


def test_what_runs_away_is_told_from_what_is_large() -> None:
    changes = np.array([[1e9, 1.0, np.inf, 1.0], [-1e9, 2.0, 1.0, np.nan]])
    assert diverged(changes).tolist() == [False, False, True, True]
