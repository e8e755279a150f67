"""What models predict of a log, kept for the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import place_effects
from flexros.gap.result import Prediction
from flexros.gap.signatures.evidence import Evidence

if TYPE_CHECKING:
    from flexros.effects import RobotWithEffects
    from flexros.gap.fit import Fit
    from flexros.gap.fit_data import FitData
    from flexros.gap.result import Explanation


def prediction_of(one: Fit, data: FitData) -> Prediction:
    """Predict a log with a fitted model.

    Args:
        one: The fitted model.
        data: The log; it need not be the one that the model was fitted to.
    """
    found = data.predict(one.predictor, one.theta[:, None], record_states=True)
    assert found.states is not None
    states = found.states[:, : 2 * one.predictor.robot.n_coordinates, 0].copy()  # keep one lane of the whole arrays
    return Prediction(found.innovation[:, :, 0].copy(), data.gain.spread, states, int(np.argmax(data.settled)))


def signature_evidence(
    model: RobotWithEffects, data: FitData, before: Explanation, after: Explanation | None
) -> Evidence:
    """Collect what the pictures of the effects' signatures are computed from.

    Args:
        model: The nominal model.
        data: The log that was fitted to.
        before: The nominal model with its predictions.
        after: The repaired model with its predictions; None where nothing was found.
    """
    repaired = None if after is None else place_effects(model.robot, after.effects).robot
    return Evidence(model.robot, data.record, data.gain, before.fit, None if after is None else after.fit, repaired)
