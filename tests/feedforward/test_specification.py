from __future__ import annotations

from typing import Any

import pytest

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.feedforward.specification import FeedforwardSpecification


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"method": "spline"}, r"s.yaml: key 'method' is 'spline', but input should be 'none', 'rigid'"),
        ({"order": 3}, r"key 'order' is 3, but input should be 1 or 2"),
        (
            {"friction": {"coulomb": -1.0}},
            r"key 'friction.coulomb.*' is -1.0, but input should be greater than or equal to 0",
        ),
        (
            {"stiffness": {"motor_1": 1e5}},
            r"stiffness is given for method 'dae', but only flexible_joint uses it; remove it",
        ),
        ({"methd": "dae"}, r"unknown key 'methd': did you mean 'method'\?"),
        ({"friction": {"viscous": float("nan")}}, r"key 'friction.viscous"),
        ({"zero_dynamics_poses": 0}, r"key 'zero_dynamics_poses' is 0"),
    ],
)
def test_wrong_settings_are_one_sentence(settings: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        validate(FeedforwardSpecification, settings, "s.yaml")


def test_default_is_the_second_order_method() -> None:
    specification = FeedforwardSpecification()
    assert (specification.method, specification.order, specification.hold_compensation) == ("dae", 2, None)
