"""Units of the signals of a proposal."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.logs.foreign.signal_source import Signal
from flexros.record.proposal.effort_unit import EffortUnit
from flexros.record.proposal.found_signals import FoundSignals
from flexros.record.proposal.joints import JointMatch
from flexros.record.proposal.units import JointSignals, Units, unit_words, units_of_motion

TIME = np.linspace(0.0, 10.0, 2001)
MATCH = JointMatch("motor_1", "arm", 1, "name")


def joints(position: str, velocity: str, factor: float) -> JointSignals:
    """A joint of a table that swings, with velocities in another unit or direction."""
    found = FoundSignals("run.csv", {"position": {"arm": position}, "velocity": {"arm": velocity}}, of_table=True)
    signals = {position: Signal(np.sin(TIME), TIME), velocity: Signal(factor * np.cos(TIME), TIME)}
    return JointSignals(found, signals, (MATCH,), {"motor_1": True})


@pytest.mark.parametrize(
    ("position", "velocity", "factor", "units"),
    [
        ("q", "dq", 1.0, ("rad", "rad/s")),
        ("q", "dq", np.degrees(1.0), ("rad", "deg/s")),
        ("q [deg]", "dq", 1.0, ("deg", "deg/s")),
        ("q", "dq [rpm]", 1.0, ("rad", "rpm")),
    ],
)
def test_names_decide_then_the_velocities_then_the_range(
    position: str, velocity: str, factor: float, units: tuple[str, str]
) -> None:
    found = units_of_motion(joints(position, velocity, factor), ("position", "velocity"), modelled=True)
    assert (found.units["position"], found.units["velocity"]) == units


def test_velocities_against_the_positions_are_told() -> None:
    found = units_of_motion(joints("q", "dq", -1.0), ("position", "velocity"), modelled=True)
    assert found.signs == {("velocity", "motor_1"): -1}
    assert "opposite at motor_1" in found.assumptions[1].taken


def test_units_of_joints_that_slide_and_the_scale_of_currents() -> None:
    units = Units({"position": "deg"})
    units.take_effort("measured_torque", EffortUnit("A", (5.0,), (-1,), {}, 0.2), ("motor_1",))
    assert (units.unit("position", rotary=False), units.unit("torque_command", rotary=False)) == ("m", "N")
    assert units.signs == {("measured_torque", "motor_1"): -1}
    scale = units.scale("measured_torque", "motor_1", rotary=True)
    assert scale is not None
    assert (scale.value, scale.unit) == (5.0, "Nm/A")
    assert units.scale("torque_command", "motor_1", rotary=True) is None


def test_joints_that_slide_are_told_with_units_of_their_own() -> None:
    assert unit_words("rad/s", {"motor_1": False, "motor_2": True}) == "rad/s, m/s at motor_1"
    assert unit_words("Nm", {"motor_1": False}) == "N"
