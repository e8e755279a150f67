"""Errors of a log with a part of a repair."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from flexros.gap.answer.partial_repairs import PartialRepairs
from flexros.gap.candidates.tolerance import Tolerance
from tests.gap.diagnosis_logs import candidates_of, predictor_of

FRICTION = "motor_1.viscous_friction"


def test_numbers_that_effects_took_over_stay_nominal_without_the_rotors_that_the_file_lacks() -> None:
    """Friction counted twice in all parts but the whole, beside the deviation of the number that was part of it."""
    tolerance = Tolerance((FRICTION, "body_1.rz.stiffness"), (0.1, 0.02), directions=np.eye(2))
    viscous = candidates_of()["viscous_friction@motor_1"]
    given = SimpleNamespace(
        lacking=frozenset({"rotor_inertia@motor_1"}),
        predictor=lambda hypothesis, _: predictor_of(*hypothesis, tolerance=tolerance),
        deviations=lambda _: np.zeros(2),
    )
    chosen = SimpleNamespace(
        hypothesis=(viscous,), predictor=predictor_of(viscous, tolerance=tolerance.known({FRICTION}))
    )
    findings: Any = SimpleNamespace(explanations=SimpleNamespace(chosen=chosen), as_given=given)
    errors: Any = None
    base = PartialRepairs(findings, errors, errors)._base(frozenset())
    assert base.predictor.tolerance.deviations == (0.0, 0.02)
