"""Errors of predictions 0.1 s ahead, of made logs and of no log."""

from __future__ import annotations

import numpy as np

from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.gap.held_out.errors_ahead import AheadErrors, errors_ahead
from tests.gap.diagnosis_logs import candidates_of, data_of, encoded, predictor_of

SPACING = 50  # samples


def ahead(effects: tuple[str, ...] = (), level: float | None = None, seed: int = 1) -> AheadErrors:
    """Errors of a log with effects, under the nominal model or with Coulomb friction."""
    hypothesis = () if level is None else (candidates_of()["coulomb_friction@motor_1"],)
    predictor = predictor_of(*hypothesis)
    theta = np.array([] if level is None else encoded(hypothesis[0], level=level))
    return errors_ahead(CandidateFit(predictor, theta, 0.0), data_of(*effects, seed=seed))


def synthetic(level: float, seed: int = 0, windows: int = 2000) -> AheadErrors:
    """White errors of a mean square."""
    squares = level * np.random.default_rng(seed).normal(size=(windows, 1)) ** 2
    return AheadErrors(squares, SPACING * np.arange(windows), np.array([1e-4]))
