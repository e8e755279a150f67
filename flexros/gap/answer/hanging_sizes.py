"""Sizes that hang on a number of the model which a log of positions hardly tells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.gap.fit.linearisation import linearise
from flexros.gap.fit.uncertainty.covariance import inverse_of

if TYPE_CHECKING:
    from flexros.gap.answer.decision import Findings

ALIKE = 0.5
"""Squared correlation with a number of the model from which a size hangs on it [1] (chosen)."""
LOOSE = 3.0
"""Deviation of a number by the log alone, over its tolerance, from which the log hardly tells it [1] (chosen)."""
SEVERAL = 2
"""Sizes that a common factor scales at least [1]: one alone is that of an effect which acts as the number does, as
viscous friction does in place of damping."""
RELEASED = 1e-6
"""Weight of the prior of a number that the log alone is to tell, over the usual one [1]: enough to invert."""


def hanging_sizes(findings: Findings) -> list[str]:
    """State which sizes hang on which number of the model, at motors that are commanded by positions.

    Without torques, and without gravity, all numbers of a servo have a common factor. Where all but one of them are
    named, the one that is not fixes it: if it is off by more than its tolerance, all sizes at the motor are.

    Args:
        findings: Fits of one log, and what the held-out log says of them.
    """
    data, chosen = findings.data, findings.explanations.chosen
    if data.record.command is None or not chosen.hypothesis:
        return []
    predictor, tolerance = chosen.predictor, chosen.predictor.tolerance
    slopes, n_effect = linearise(predictor, data, chosen.theta).slopes, predictor.n_effect
    directions = np.eye(len(tolerance.names)) if tolerance.directions is None else tolerance.directions
    slopes = np.hstack([slopes[:, :n_effect], slopes[:, n_effect:] @ directions.T])
    prior = np.concatenate([np.zeros(n_effect), np.full(len(tolerance.names), data.misfit)])
    information, robot = slopes.T @ slopes, findings.model.robot
    found: dict[tuple[str, str], list[str]] = {}
    for number, (name, deviation) in enumerate(zip(tolerance.names, tolerance.deviations, strict=True)):
        motor = name.partition(".")[0]
        own = [one for one in chosen.hypothesis if one.location == motor]
        if motor not in robot.joint_names or not own or any(name in one.effect().numbers(robot, motor) for one in own):
            continue
        place, free = n_effect + number, prior.copy()
        free[place] *= RELEASED
        covariance = inverse_of(information + np.diag(free))
        if np.sqrt(covariance[place, place]) < LOOSE:
            continue
        alone = deviation * float(np.sqrt(covariance[place, place]))
        told = "does not tell" if alone >= 1 else f"tells to {100 * alone:.0f} % only"
        for one in own:
            column = int(np.argmax(chosen.columns((one.name,))))
            shared = covariance[column, place] ** 2
            if shared > ALIKE * covariance[column, column] * covariance[place, place]:
                found.setdefault((name, told), []).append(one.name)
    return [
        f"{', '.join(sorted(sizes))} hang on {name}, which this log {told}: they are as stated if it is right "
        "within its tolerance. Without torques all numbers of a servo have a common factor where no weight shows"
        for (name, told), sizes in found.items()
        if len(sizes) >= SEVERAL
    ]
