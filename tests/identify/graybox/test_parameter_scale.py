from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.parameter_scale import parameter_scale

if TYPE_CHECKING:
    from flexros.robot.robot import Robot

MIXED = ["body_1.ry.stiffness", "body_2.length.x", "motor_1.viscous_friction", "motor_1.inertia", "body_1.length.z"]


def test_positive_parameters_are_logarithmic_and_others_linear(e12: Robot) -> None:
    scale = parameter_scale(e12, MIXED)
    assert scale.logarithmic.tolist() == [True, False, False, True, False]


def test_scaled_values_return(e12: Robot) -> None:
    scale = parameter_scale(e12, MIXED)
    values = np.array([7e4, -0.9, 3.0, 80.0, 0.0])
    np.testing.assert_allclose(scale.values(scale.scaled(values)), values, rtol=1e-14)


def test_per_value_is_the_derivative(e12: Robot) -> None:
    scale, step = parameter_scale(e12, MIXED), 1e-6
    x = scale.scaled(np.array([7e4, -0.9, 3.0, 80.0, 0.1]))
    difference = (scale.values(x + step) - scale.values(x - step)) / (2 * step)
    np.testing.assert_allclose(scale.per_value(scale.values(x)), difference, rtol=1e-8)


def test_default_bounds_are_a_decade_either_way_and_no_negative_friction(e12: Robot) -> None:
    scale = parameter_scale(e12, MIXED)
    lower, upper = (scale.values(bound) for bound in scale.bounds())
    np.testing.assert_allclose(lower, [1e4, -np.inf, 0.0, 10.0, -np.inf])
    np.testing.assert_allclose(upper, [1e6, np.inf, np.inf, 1e3, np.inf])


def test_given_bounds_replace_the_default(e12: Robot) -> None:
    scale = parameter_scale(e12, MIXED)
    lower, upper = scale.bounds({"body_1.ry.stiffness": (5e4, 2e5), "body_2.length.x": (0.9, 1.1)})
    np.testing.assert_allclose(scale.values(lower)[:2], [5e4, 0.9])
    np.testing.assert_allclose(scale.values(upper)[:2], [2e5, 1.1])


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        (
            {"body_1.ry.stiffness": (-1.0, 2.0)},
            r"-1 and 2, allowed is a lower bound above 0 and below the upper",
        ),
        ({"body_2.length.x": (2.0, 1.0)}, r"body_2.length.x .* 2 and 1, allowed is a lower bound below"),
        ({"body_9.mass": (1.0, 2.0)}, r"unknown fitted parameter 'body_9.mass' in bounds"),
    ],
)
def test_wrong_bounds_are_refused(e12: Robot, bounds: dict[str, tuple[float, float]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        parameter_scale(e12, MIXED).bounds(bounds)


def test_no_unknown_parameter_is_refused(e12: Robot) -> None:
    with pytest.raises(InputError, match=r"no unknown parameter is named for robot e12: give names, or list them"):
        parameter_scale(e12, [])


def test_unknown_name_is_refused_with_the_nearest(e12: Robot) -> None:
    with pytest.raises(InputError, match=r"did you mean 'body_1.ry.stiffness'"):
        parameter_scale(e12, ["body_1.ry.stifness"])


def test_name_given_twice_is_refused(e12: Robot) -> None:
    with pytest.raises(InputError, match=r"name body_3.mass more than once; name it only once"):
        parameter_scale(e12, ["body_3.mass", "body_3.mass"])
