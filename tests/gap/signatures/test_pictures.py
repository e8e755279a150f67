"""Each effect shows its signature in its picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import parse_effect, place_effects
from flexros.gap.signatures.base import Picture, signatures
from flexros.gap.signatures.disturbance_torque import disturbance_torque
from flexros.gap.signatures.signature_data import SignatureData
from flexros.record.record import ToolRecord

pytestmark = pytest.mark.slow


def picture(name: str, data: SignatureData) -> Picture:
    result = signatures()[name]().picture(data, "motor_1")
    assert result is not None
    return result


def test_disturbance_torque_is_the_friction(friction: SignatureData) -> None:
    speed = friction.motion.speed[friction.rows, 0]
    expected = -0.3 * np.tanh(speed / 0.05)
    estimate = friction.disturbance[friction.rows, 0]
    assert np.sqrt(np.mean((estimate - expected) ** 2)) < 0.25 * 0.3


def test_disturbance_torque_is_zero_without_a_gap(friction: SignatureData) -> None:
    assert friction.disturbance_after is not None
    assert np.std(friction.disturbance_after[friction.rows]) < 0.02


def test_disturbance_torque_is_linear_in_the_errors(friction: SignatureData) -> None:
    twice = disturbance_torque(2 * friction.before.innovations, friction.record, friction.robot, friction.observer)
    assert twice == pytest.approx(2 * friction.disturbance)


def test_friction_is_a_step_over_speed(friction: SignatureData) -> None:
    curve = picture("torque_over_speed", friction).series["before"]
    fast = np.abs(curve.x) > 3
    assert curve.y[fast] == pytest.approx(-0.3 * np.sign(curve.x[fast]), abs=0.06)
    repaired = picture("torque_over_speed", friction).series["after"]
    assert np.abs(repaired.y).max() < 0.05


def test_friction_acts_at_once_after_a_reversal(friction: SignatureData) -> None:
    curve = picture("torque_after_reversal", friction).series["before"]
    assert curve.y[curve.x > 0.5] == pytest.approx(0.3, abs=0.06)


def test_friction_that_stays_is_level_over_time(friction: SignatureData) -> None:
    curve = picture("friction_over_time", friction).series["before"]
    assert np.ptp(curve.y[5:-1]) < 0.15
    assert curve.y[5:-1].mean() == pytest.approx(0.29, abs=0.04)


def test_ripple_is_a_peak_at_its_order(ripple: SignatureData) -> None:
    curve = picture("order_spectrum", ripple).series["before"]
    assert curve.x[curve.y.argmax()] == pytest.approx(6.0, abs=0.3)
    assert curve.y.max() == pytest.approx(0.1, rel=0.4)
    assert curve.y.max() > 5 * np.median(curve.y)


def test_ripple_is_a_harmonic_over_a_turn(ripple: SignatureData) -> None:
    curve = picture("torque_over_rotor_angle", ripple).series["before, forward"]
    harmonic = np.sin(6 * curve.x)
    assert 2 * np.mean(harmonic * curve.y) > 0.04
    rest = curve.y - 2 * np.mean(harmonic * curve.y) * harmonic
    assert rest.std() < curve.y.std()


def test_delay_shifts_all_frequencies_alike(late: SignatureData) -> None:
    curve = picture("time_shift", late).series["before"]
    inside = (curve.x > 5) & (curve.x < 40)
    assert np.median(curve.y[inside]) == pytest.approx(1.0, abs=0.3)  # two samples of 0.5 ms
    assert np.abs(np.median(picture("time_shift", late).series["after"].y)) < 0.1


def test_gain_turns_the_effective_torque(weak: SignatureData) -> None:
    curve = picture("effective_torque", weak).series["mean"]
    assert np.polyfit(curve.x, curve.y, 1)[0] == pytest.approx(0.9, abs=0.03)


def test_gain_is_a_slope_over_acceleration(weak: SignatureData) -> None:
    curve = picture("torque_over_acceleration", weak).series["before"]
    assert np.polyfit(curve.x, curve.y, 1)[0] < 0


def test_a_softer_spring_is_a_slope_of_the_torsion(softer_gear: SignatureData) -> None:
    curve = picture("torsion_over_torque", softer_gear).series["rising torque"]
    # of 80 Nm/rad instead of 100
    assert np.polyfit(curve.x, curve.y, 1)[0] == pytest.approx(1 / 80 - 1 / 100, rel=0.4)
    assert np.abs(picture("torsion_over_torque", softer_gear).series["after"].y).max() < 0.3 * np.abs(curve.y).max()


def test_a_gap_is_a_step_of_the_torsion(loose_gear: SignatureData) -> None:
    curve = picture("torsion_over_torque", loose_gear).series["rising torque"]
    loaded = np.abs(curve.x) > 3
    assert np.median(curve.y[loaded] * np.sign(curve.x[loaded])) == pytest.approx(0.005, rel=0.4)


def test_response_of_the_log_is_that_of_the_robot(friction: SignatureData) -> None:
    unbent = replace(friction, before=friction.after, record=friction.record)
    series = picture("frequency_response", unbent).series
    assert len(series["log"].x) > 3
    expected = np.interp(series["log"].x, series["before"].x, series["before"].y)
    assert np.median(series["log"].y / expected) == pytest.approx(1.0, abs=0.2)


def test_stiffness_moves_the_peaks_of_the_response(friction: SignatureData) -> None:
    robot = friction.robot
    softer = place_effects(robot, [parse_effect("stiffness_error@body_1.rz:relative=-0.3", "test")]).robot
    response = picture("frequency_response", replace(friction, repaired=softer))
    before, after = response.series["before"], response.series["after"]
    assert before.x[before.y.argmin()] > 1.02 * after.x[after.y.argmin()]


def test_steps_of_a_quantized_encoder_have_gaps(friction: SignatureData) -> None:
    step = 2e-3
    coarse = replace(friction.record, position=step * np.round(friction.record.position / step))
    smooth, stairs = (
        picture("encoder_steps", replace(friction, record=record)).series["log"] for record in (friction.record, coarse)
    )
    assert np.mean(smooth.y == 0) < 0.1
    assert np.mean(stairs.y == 0) > 0.8


def test_tool_errors_are_shown_over_the_position(friction: SignatureData) -> None:
    time = np.arange(0, 8, 0.01)
    position = np.interp(time, np.arange(16000) * 5e-4, friction.record.position[:, 0])
    error = np.zeros((800, 3))
    error[:, 0] = 1e-4 * position
    record = replace(friction.record, tool=ToolRecord(time, np.zeros((800, 3))))
    curve = picture("tool_error", replace(friction, record=record, tool_error=error)).series["x"]
    assert curve.y == pytest.approx(0.1 * curve.x, abs=1e-6)


def test_torque_over_position_separates_bias_from_friction(friction: SignatureData) -> None:
    series = picture("torque_over_position", friction).series
    assert series["before, forward"].y.mean() == pytest.approx(-series["before, backward"].y.mean(), abs=0.03)


def test_torque_over_time_is_that_of_equal_times(friction: SignatureData) -> None:
    curve = picture("torque_over_time", friction).series["before"]
    time = friction.rows * friction.record.sample_time
    whole = friction.disturbance[friction.rows, 0]
    middle = len(curve.x) // 2
    near = np.abs(time - curve.x[middle]) < 0.5 * np.diff(curve.x).mean()
    assert curve.y[middle] == pytest.approx(whole[near].mean(), abs=0.03)
    assert curve.x[-1] > 0.9 * time[-1]


def test_locations_are_assigned_to_motors(friction: SignatureData) -> None:
    assert friction.motor_of("motor_1") == friction.motor_of("body_2.rz") == friction.motor_of("tool") == 0


def test_torque_that_does_not_vary_has_no_frequency_response(friction: SignatureData) -> None:
    still = replace(friction.record, torque=np.ones_like(friction.record.torque))
    assert "log" in picture("frequency_response", friction).series
    assert not len(picture("frequency_response", replace(friction, record=still)).series["log"].x)
