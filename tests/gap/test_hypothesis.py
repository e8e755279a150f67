"""Numbers that are fitted keep within the ranges of their effects."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import effects
from flexros.effects.ranges import Range
from flexros.gap.hypothesis import free_parameter

SIGNED = [
    (name, parameter)
    for name, effect in effects().items()
    for parameter, allowed in effect.ranges.items()
    if allowed.signed
]


def test_negative_values_may_have_a_bound_of_their_own() -> None:
    free = free_parameter("relative", Range("relative", 0.01, 10.0, 6, signed=True, negative=0.9), 1.0)
    assert [float(free.decode(np.array(bound))) for bound in free.bounds] == pytest.approx([-0.9, 10.0])
    assert min(free.starts) == -0.9
    assert max(free.starts) > 0.9
    assert free_parameter("level", Range("torque", 0.01, 10.0, signed=True), 2.0).bounds == (-1.0, 1.0)


@pytest.mark.parametrize(("name", "parameter"), SIGNED)
def test_effects_allow_the_bounds_of_their_ranges(name: str, parameter: str) -> None:
    effect = effects()[name]
    others = {"knee": 1e-3} if name == "nonlinear_stiffness" else {}
    free = free_parameter(parameter, effect.ranges[parameter], 1.0)
    for number in (*free.bounds, *map(free.encode, free.starts)):
        value = float(free.decode(np.array(number)))
        assert getattr(effect(**{**others, parameter: value}), parameter) == value
