"""Units in the names of columns."""

from __future__ import annotations

import pytest

from flexros.record.proposal.column_units import name_without_unit, unit_in_name


@pytest.mark.parametrize(("name", "kind", "rest", "unit"), [
    ("Angle (rad)", "position", "Angle ", "rad"), ("Speed (rad/sec)", "velocity", "Speed ", "rad/s"),
    ("speed_rad_per_s", "velocity", "speed_", "rad/s"), ("vel [°/s]", "velocity", "vel ", "deg/s"),
    ("tau [N*m]", "torque", "tau ", "Nm"), ("tau_nm_2", "torque", "tau__2", "Nm"), ("pos (m)", "position", "pos ", "m"),
    ("speed [rev/s]", "velocity", "speed ", "turn/s"), ("Current (units)", "torque", "Current ", None),
    ("Speed (rad)", "velocity", "Speed ", None),
])  # fmt: skip
def test_units_are_read(name: str, kind: str, rest: str, unit: str | None) -> None:
    assert (name_without_unit(name), unit_in_name(name, kind)) == (rest, unit)


@pytest.mark.parametrize("name", ["q[0]", "q1", "pos[elbow]", "motor_m", "rad", "", "wristRad", "tau_1"])
def test_other_names_have_none(name: str) -> None:
    assert name_without_unit(name) == name
    assert unit_in_name(name, "position") is None
