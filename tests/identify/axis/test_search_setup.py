"""Starts, bounds and steps."""

from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.identify.axis import AxisStructure
from flexros.identify.axis.search_setup import bounds_around, short_steps, starting_values
from tests.identify.axis.recorded_axis import TRUTH, axis_of, recorded_axis

RECORD = axis_of(recorded_axis(samples=400))
PLAIN = AxisStructure(gear="linear")
GIVEN = {name: TRUTH[name] for name in PLAIN.names}


def test_what_is_given_needs_no_frequencies() -> None:
    assert starting_values(RECORD, AxisStructure(), 0.02, (), (), GIVEN) == GIVEN


def test_friction_starts_above_zero() -> None:
    given = {name: value for name, value in GIVEN.items() if not name.endswith("friction")}
    begin = starting_values(RECORD, PLAIN, 0.02, (), (), given)
    assert begin["coulomb_friction"] == pytest.approx(1e-3 * RECORD.rms_torque)
    assert begin["viscous_friction"] > 0


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({}, r"for motor_inertia, arm_1_inertia, gear_stiffness, gear_damping; give antiresonances"),
        (
            {"motor_inertja": 1.0},
            r"unknown parameter of the axis 'motor_inertja' in start: did you mean 'motor_inertia'",
        ),
        ({"motor_inertia": 0.0}, r"start: motor_inertia is 0, but must be above zero; correct it"),
    ],
)
def test_impossible_starts_are_named(start: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        starting_values(RECORD, PLAIN, 0.02, (), (), start)


def test_bounds_are_a_factor_or_what_is_given() -> None:
    structure = PLAIN.model_copy(update={"offset": True})
    bounds = bounds_around(structure, GIVEN | {"offset": 0.0}, {"gear_damping": (1.0, 99.0)}, RECORD)
    assert bounds["motor_inertia"] == pytest.approx((0.4, 40.0))
    assert bounds["coulomb_friction"] == pytest.approx((0.02, 2e4))
    assert bounds["gear_damping"] == (1.0, 99.0)
    assert bounds["offset"][0] == -bounds["offset"][1] < 0


@pytest.mark.parametrize("pair", [(2.0, 1.0), (-1.0, 1.0)])
def test_bounds_without_room_are_refused(pair: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"bounds: gear_damping .* above 0 and below the upper one"):
        bounds_around(PLAIN, GIVEN, {"gear_damping": pair}, RECORD)


def test_steep_friction_needs_shorter_steps() -> None:
    assert short_steps(GIVEN, RECORD, 0.02) == 1
    assert short_steps(GIVEN, RECORD, 0.0006) == 13
