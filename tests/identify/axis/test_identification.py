"""Known truth found again: parameters within their intervals, and the gain of the nonlinear gear."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.axis import AxisStructure, OneAxisIdentification, identify_one_axis
from flexros.robot import load_robot
from tests.identify.axis.recorded_axis import EFFECTS, TRUTH, recorded_axis, three_mass

pytestmark = pytest.mark.slow

TWO_MASS = load_robot("two_mass")
FREQUENCIES = {"antiresonances": [15.9], "resonances": [25.2]}


@pytest.fixture(scope="module")
def identification() -> OneAxisIdentification:
    return identify_one_axis(recorded_axis(), TWO_MASS, validation=recorded_axis(seed=2), **FREQUENCIES)


@pytest.mark.parametrize("name", sorted(TRUTH))
def test_parameter_lies_within_its_interval(identification: OneAxisIdentification, name: str) -> None:
    low, high = identification.nonlinear.interval(name, width=3.0)
    assert low <= TRUTH[name] <= high
    assert high / low < (1.06 if name.endswith("friction") else 1.03)


def test_nonlinear_gear_explains_what_the_linear_one_cannot(identification: OneAxisIdentification) -> None:
    assert identification.validation is not None
    assert identification.linear_validation is not None
    assert identification.gain > 0.4
    assert identification.validation.simulation > 98.5
    assert identification.linear_validation.simulation < 95
    assert identification.validation.prediction > 99.99
    assert abs(identification.nonlinear.whiteness) < 0.15 < abs(identification.linear.whiteness)


def test_fit_holds_on_the_validation_log(identification: OneAxisIdentification) -> None:
    assert identification.validation is not None
    assert identification.validation.error == pytest.approx(identification.nonlinear.quality.error, rel=0.1)


def test_linear_steps_start_near(identification: OneAxisIdentification) -> None:
    assert identification.start["motor_inertia"] == pytest.approx(4.0, rel=0.05)
    assert "gear_knee" not in identification.start


def test_linear_gear_shows_no_gain_and_no_knee() -> None:
    result = identify_one_axis(recorded_axis(EFFECTS[1:]), TWO_MASS, **FREQUENCIES)
    assert abs(result.gain) < 1e-3
    low, high = result.nonlinear.interval("gear_stiffening")
    assert low <= 1.0 <= high
    assert result.linear.interval("gear_stiffness", 3.0)[0] <= 6e4 <= result.linear.interval("gear_stiffness", 3.0)[1]


def test_three_masses_from_starts_three_percent_off() -> None:
    stiffness = np.array([[6e4, -6e4, 0], [-6e4, 11e4, -5e4], [0, -5e4, 5e4]])
    inertia = np.array([4.0, 4.0, 2.0])
    resonances, antiresonances = (
        1.03 * np.sqrt(np.abs(np.sort(np.linalg.eigvals(stiffness[k:, k:] / inertia[k:, None]).real))) / (2 * np.pi)
        for k in (0, 1)
    )
    result = identify_one_axis(
        recorded_axis(robot=three_mass()),
        three_mass(),
        AxisStructure(masses=3),
        antiresonances=antiresonances.tolist(),
        resonances=resonances[1:].tolist(),
    )
    truth = TRUTH | {"arm_1_inertia": 4.0, "arm_2_inertia": 2.0, "arm_stiffness": 5e4, "arm_damping": 20.0}
    for name, value in truth.items():
        low, high = result.nonlinear.interval(name, width=3.5)
        assert low <= value <= high
    assert result.nonlinear.parameters["arm_stiffness"] == pytest.approx(5e4, rel=0.01)


def test_unknown_bound_is_named() -> None:
    with pytest.raises(InputError, match=r"parameter of the axis 'gear_nee' in bounds: did you mean 'gear_knee'"):
        identify_one_axis(recorded_axis(samples=300), TWO_MASS, bounds={"gear_nee": (1.0, 2.0)})
