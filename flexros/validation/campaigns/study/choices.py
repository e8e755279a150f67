"""The six estimators of the study and what was published of them (Moberg 2007, Paper A, section 6)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StudyEstimator:
    """One of the estimators that are compared.

    Attributes:
        name: Name in the paper, with 15 for all positions and 1 for one.
        estimator: "LLS", "LLSM" or "NLS".
        weights: "user" or "optimal".
        all_positions: Whether all positions are used, or the single most informative one.
        published_reasonable: Published share of reasonable models: normalised LLS cost with user weights at most 1.5.
        published_springs: Published share of models whose springs lie within a factor of 2 of the best model's.
    """

    name: str
    estimator: str
    weights: str
    all_positions: bool
    published_reasonable: float
    published_springs: float


SIX = (
    StudyEstimator("LLSM15U", "LLSM", "user", True, 0.64, 0.43),
    StudyEstimator("LLS15U", "LLS", "user", True, 0.80, 0.62),
    StudyEstimator("LLS15O", "LLS", "optimal", True, 0.35, 0.21),
    StudyEstimator("NLS15U", "NLS", "user", True, 0.03, 0.02),
    StudyEstimator("NLS15O", "NLS", "optimal", True, 0.00, 0.00),
    StudyEstimator("LLS1U", "LLS", "user", False, 0.02, 0.02),
)
"""In the order of the paper."""

REFERENCE = "LLS15U"
"""The estimator whose best model the parameters are divided by."""

REASONABLE = 1.5
"""Largest normalised LLS cost with user weights of a reasonable model."""

BEST = 1.05
"""Largest normalised cost of the models in Table 1 of the paper."""
