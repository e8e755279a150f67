"""A search goes on beside a line that hides effects, and only then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.search.fits.candidate_fits import Search
from flexros.gap.search.forward_selection import explain
from flexros.gap.search.periodic.lines import beside_line
from flexros.gap.search.prepare import prepare_search
from tests.gap.diagnosis_logs import FEW_EFFECTS, MODEL, SECONDS, WHOLE, data_of, search_of, settings_of

pytestmark = pytest.mark.slow

FREQUENCY, VISCOUS = 41.3, "viscous_friction@motor_1"


def shaken(amplitude: float, length: float = SECONDS) -> Search:
    """Search in a log of a little friction whose encoder moves at one frequency all the time."""
    data = data_of(f"{VISCOUS}:coefficient=5e-4", length=length)
    time = data.record.sample_time * np.arange(data.record.n_samples)
    wave = amplitude * data.gain.noise * np.sin(2 * np.pi * FREQUENCY * time)[:, None]
    record = replace(data.record, position=data.record.position + wave)
    return prepare_search(fit_null(replace(data, record=record), MODEL, Tolerance()), settings_of(*FEW_EFFECTS))


def test_a_line_that_is_most_of_what_is_left_is_left_out() -> None:
    search = shaken(30.0)
    beside = beside_line(search, search.null.fit)
    assert beside is not None
    assert beside.data.line is not None
    assert beside.data.line.frequency == pytest.approx(FREQUENCY, abs=0.01)
    assert beside.data.n_values < search.data.n_values
    assert "41.3 Hz" in beside.data.record.warnings[-1]
    assert beside_line(beside, beside.null.fit) is None


def test_effects_that_a_line_hides_are_found_beside_it() -> None:
    explanations = explain(shaken(30.0, WHOLE))
    assert explanations.chosen.names == {VISCOUS}
    assert explanations.beside is not None
    level = explanations.chosen.chi2 / explanations.beside.n_values
    assert level < 1.1  # where the log begins, the predictor has not settled to the line


def test_a_log_without_a_line_is_searched_once() -> None:
    search = search_of(f"{VISCOUS}:coefficient=5e-4", among=FEW_EFFECTS)
    assert beside_line(search, search.null.fit) is None
    assert explain(search).beside is None
