"""Curves over time in an answer: the times for which they hold."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.effects.torque_drift import TorqueDrift
from flexros.gap.fit.estimates import placed_effects

if TYPE_CHECKING:
    from flexros.gap.answer.decision import Findings


def drift_warnings(findings: Findings) -> list[str]:
    """Return one sentence for every curve over time: of another start it says nothing.

    A held-out part that continues the fitted log is predicted with the last value of the curve, another log as if the
    curve repeated from its start on; so is every run of the patch.

    Args:
        findings: Fits of one log, and what the held-out log says of them.
    """
    fitted, held = findings.data.record, findings.held.record
    continues = held.begin >= fitted.begin + (fitted.n_samples - 1) * fitted.sample_time
    how = "the held-out part is predicted with its last value" if continues else "the held-out log as if it repeated"
    drifts = [one for one in placed_effects(findings.explanations.chosen) if isinstance(one.effect, TorqueDrift)]
    return [
        f"the {one.effect.words} at {one.location} is that of the fitted log, {one.effect.begin:.3g} to "
        f"{one.effect.end:.3g} s after its start; {how}. Of another start it says nothing: where it does not repeat, "
        f"put torque_bias@{one.location} into the patch instead"
        for one in drifts
        if isinstance(one.effect, TorqueDrift)
    ]
