"""Nominal viscous friction that an explanation of a measured log moves far out of its tolerance."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.prepare import prepare_search
from flexros.gap.search.within_tolerance import with_far_numbers
from tests.gap.diagnosis_logs import MODEL, ROBOT, record_of, settings_of

pytestmark = pytest.mark.slow

COULOMB, VISCOUS, NUMBER = "coulomb_friction@motor_1", "viscous_friction@motor_1", "motor_1.viscous_friction"


@pytest.mark.parametrize(("tolerance", "named"), [(0.05, True), (0.3, False)])
def test_it_is_named_as_an_effect(tolerance: float, named: bool) -> None:
    """Of a gantry two frictions that were 1.8 times as large as stated were numbers of the model alone."""
    nominal = ROBOT.parameters[NUMBER].value
    record = record_of(f"{COULOMB}:level=0.05", f"{VISCOUS}:coefficient={0.5 * nominal}")
    settings = settings_of("coulomb_friction", "viscous_friction")
    data = fit_data(replace(record, imported=True), MODEL, settings)
    search = prepare_search(fit_null(data, MODEL, Tolerance((NUMBER,), (tolerance,))).farther(), settings)
    (coulomb,) = (one for one in search.candidates() if one.name == COULOMB)
    null = search.null.fit
    added = search.additions(search.directions([coulomb]), null, search.surroundings(null))
    chosen = search.completed(search.together(null, added))
    found = with_far_numbers(search, chosen, [])
    assert (VISCOUS in found.names) is named
    if named:
        sizes = dict(zip((one.name for one in found.hypothesis), found.predictor.values(found.theta), strict=True))
        assert sizes[VISCOUS]["coefficient"] == pytest.approx(0.5 * nominal, rel=0.1)
