"""Sizes of an answer, with the doubt of a scale that all of them have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.answer.decision import rivals_of
from flexros.gap.fit.estimates import covariance_of
from flexros.gap.search.model_probability import contrast_of

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.gap.answer.decision import Findings
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.schema import CauseParameter


def covariance_of_answer(findings: Findings) -> tuple[tuple[str, ...], FloatArray]:
    """Compute the covariance of the parameters of the chosen explanation, in their units.

    A rival with a gain of the torque in place of an inertia, or the other way round, has other sizes of all that the
    torque meets. Which of the two it is the log does not tell, so that their difference, by the probability of the
    rival, is part of the covariance (Hoeting et al. 1999: the variance between models).

    Args:
        findings: Fits of one log, and what the held-out log says of them.

    Returns:
        Names, e.g. "coulomb_friction@motor_1.level", and covariance, shape (p, p).
    """
    explanations = findings.explanations
    chosen, probabilities = explanations.chosen, dict(zip(explanations.rivals, explanations.probabilities))
    names, covariance = covariance_of(chosen, findings.data, findings.settings, findings.held)
    rivals = [
        fit
        for fit in rivals_of(explanations, findings.settings, findings.elsewhere)
        if contrast_of(fit.hypothesis, chosen.hypothesis).one_scale
    ]
    total = sum(probabilities[fit] for fit in (chosen, *rivals)) if rivals else 1.0
    own = _values(chosen)
    for fit in rivals:
        other = _values(fit)
        difference = np.array([other.get(name, 0.0) - own[name] for name in names])
        covariance = covariance + probabilities[fit] / total * np.outer(difference, difference)
    return names, covariance


def parameters_of_answer(findings: Findings) -> list[dict[str, CauseParameter]]:
    """Return the parameters of every effect of the chosen explanation, with the standard deviations of the answer."""
    chosen = findings.explanations.chosen
    names, covariance = covariance_of_answer(findings)
    deviations = dict(zip(names, np.sqrt(np.maximum(np.diag(covariance), 0.0)).tolist()))
    return [
        {name: _with_std(size, deviations[f"{one.name}.{name}"]) for name, size in own.items()}
        for one, own in zip(chosen.hypothesis, findings.sizes(chosen), strict=True)
    ]


def _with_std(size: CauseParameter, std: float) -> CauseParameter:
    """Return a size with another standard deviation, above which it is not determined."""
    lost = size.std <= abs(size.value) < std
    return size.model_copy(update={"std": std, "determined": size.determined and not lost})


def _values(fit: CandidateFit) -> dict[str, float]:
    """Return the fitted parameters of a fit by name, as in `covariance_of`."""
    values = zip(fit.hypothesis, fit.predictor.values(fit.theta), strict=True)
    return {f"{one.name}.{free.name}": own[free.name] for one, own in values for free in one.free}
