"""Sizes that are relative to the gains of the robot file, after a diagnosis that began with others."""

from __future__ import annotations

import pytest

from flexros.gap.answer.rough_gains import _cause_on_file
from flexros.gap.schema import Cause, CauseParameter


@pytest.mark.parametrize(
    ("value", "std", "factor", "restated", "determined"),
    [(0.02, 0.05, 100.0, (101.0, 5.0), True), (-0.5, 0.1, 2.0, (0.0, 0.2), False)],
)
def test_a_restated_size_is_determined_where_it_is_above_its_deviation(
    value: float, std: float, factor: float, restated: tuple[float, float], determined: bool
) -> None:
    size = CauseParameter(value=value, std=std, unit="1", determined=std <= abs(value))
    cause = Cause(
        effect="servo_stiffness_error",
        location="motor_1",
        probability=1.0,
        parameters={"relative": size},
        closed_fraction=None,
        determined=size.determined,
    )
    found = _cause_on_file(cause, factor)
    assert (found.parameters["relative"].value, found.parameters["relative"].std) == pytest.approx(restated)
    assert found.parameters["relative"].determined == found.determined == determined
