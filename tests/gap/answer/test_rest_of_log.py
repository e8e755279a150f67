"""What is left in the rest of a log, of which a part was used."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexros.gap.answer.rest_of_log import changes_over_log
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from tests.gap.diagnosis_logs import MODEL, WHOLE, record_of


def test_what_changes_behind_the_part_that_is_used_is_told() -> None:
    """A log of half an hour had been explained by a third of it, whatever friction did in the rest."""
    log = record_of(length=WHOLE)
    end = round(0.6 * log.n_samples)
    null = fit_null(fit_data(log.part(0, end), MODEL, DiagnosisSettings()), MODEL, Tolerance())
    behind = log.part(end, log.n_samples)
    assert changes_over_log([behind], null.fit, null) == []
    warm = replace(behind, torque=behind.torque + 0.2 * np.sign(np.gradient(behind.position, axis=0)))
    (text,) = changes_over_log([behind, warm], null.fit, null)
    assert f"from {behind.begin:.4g} to" in text
