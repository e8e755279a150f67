"""Topics of a log brought together, or refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator

from flexros.errors import InputError
from flexros.identify.frf.aligned_log import align
from flexros.logs.time_series import JointSeries, Log
from tests.identify.frf.recorded_experiment import Recorded


def rows(series: JointSeries, keep: np.ndarray | slice) -> JointSeries:
    parts = {name: getattr(series, name) for name in ("position", "velocity", "effort")}
    return JointSeries(
        series.stamp[keep], series.names, **{name: None if part is None else part[keep] for name, part in parts.items()}
    )


def with_commands(log: Log, **changed: object) -> Log:
    assert log.joint_commands is not None
    return replace(log, joint_commands=replace(log.joint_commands, **changed))


def test_signals_are_those_of_the_log(recorded: Recorded) -> None:
    found = align(recorded.log, recorded.plan)
    assert recorded.log.joint_commands is not None
    np.testing.assert_array_equal(found.numbers, np.arange(recorded.plan.n_samples))
    np.testing.assert_array_equal(found.torque, recorded.log.joint_commands.effort)
    assert found.names == ("motor_1", "motor_2")
    assert found.warnings == ()


def test_joints_are_ordered_by_name(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_commands is not None
    assert log.joint_commands.effort is not None
    turned = with_commands(log, names=("motor_2", "motor_1"), effort=log.joint_commands.effort[:, ::-1].copy())
    np.testing.assert_array_equal(align(turned, recorded.plan).torque, log.joint_commands.effort)


def test_foreign_log_begins_with_its_first_measurement(recorded: Recorded) -> None:
    log, shift = recorded.log, 123_456_789_000
    assert log.joint_commands is not None
    states = replace(log.joint_states, stamp=log.joint_states.stamp + shift)
    foreign = Log(states, replace(log.joint_commands, stamp=log.joint_commands.stamp + shift))
    np.testing.assert_array_equal(align(foreign, recorded.plan).numbers, np.arange(recorded.plan.n_samples))


def test_missing_command_was_held(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_commands is not None
    keep = np.delete(np.arange(recorded.plan.n_samples), 700)
    found = align(replace(log, joint_commands=rows(log.joint_commands, keep)), recorded.plan)
    np.testing.assert_array_equal(found.torque[700], found.torque[699])
    assert found.warnings == ("1 measurements have no command with the same stamp; the command before was held",)


def test_hole_in_the_commands_of_a_record_is_refused(recorded: Recorded) -> None:
    """Six commands in a row; the same hole in a move between records does no harm."""
    log, segment = recorded.log, recorded.plan.segments[0]
    assert log.joint_commands is not None
    keep = np.delete(np.arange(recorded.plan.n_samples), np.arange(segment.first + 20, segment.first + 26))
    found = align(replace(log, joint_commands=rows(log.joint_commands, keep)), recorded.plan)
    with pytest.raises(InputError, match="6 commands in a row are missing at .* s within a period, allowed are 5"):
        found.rows(segment.first, segment.first + segment.period, "a period")
    found.rows(0, segment.first, "the way there")


def test_many_missing_commands_are_refused(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_commands is not None
    keep = np.delete(np.arange(recorded.plan.n_samples), np.s_[100:5000])
    with pytest.raises(
        InputError, match="4900 of .* measurements have no command with the same stamp, allowed is a share"
    ):
        align(replace(log, joint_commands=rows(log.joint_commands, keep)), recorded.plan)


def test_what_acted_before_the_first_and_after_the_last_command_is_not_known(recorded: Recorded) -> None:
    log, n = recorded.log, recorded.plan.n_samples
    assert log.joint_commands is not None
    found = align(replace(log, joint_commands=rows(log.joint_commands, slice(500, n - 800))), recorded.plan)
    assert (found.first_command, found.last_command) == (500, n - 801)
    assert found.rows(500, n - 800, "it") == slice(500, n - 800)
    with pytest.raises(
        InputError, match=r"the commands of the log begin at 0\.2500 s, experiment 1 at 0\.2495 s, so the torque that"
    ):
        found.rows(499, n - 800, "experiment 1")
    with pytest.raises(InputError, match=r"the commands of the log end at .*, experiment 1 lasts until .*partial=true"):
        found.rows(500, n - 799, "experiment 1")


def test_measured_torque_stands_in_for_commands(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_commands is not None
    measured = replace(
        log, joint_states=replace(log.joint_states, effort=log.joint_commands.effort), joint_commands=None
    )
    found = align(measured, recorded.plan)
    np.testing.assert_array_equal(found.torque, log.joint_commands.effort)
    (warning,) = found.warnings
    assert "the log has no joint_commands; the measured torques of joint_states" in warning


def test_log_without_torque_or_position_is_refused(recorded: Recorded) -> None:
    log = recorded.log
    with pytest.raises(InputError, match="the log has neither commanded torques .* nor measured ones"):
        align(replace(log, joint_commands=None), recorded.plan)
    with pytest.raises(InputError, match=r"the log has no joint_states\.position, without which"):
        align(replace(log, joint_states=replace(log.joint_states, position=None)), recorded.plan)


def test_missing_samples_are_interpolated(recorded: Recorded) -> None:
    """A lost message and one that is not finite, as in a log that is diagnosed."""
    states = recorded.log.joint_states
    position = np.array(states.position)
    position[5, 1] = np.nan
    kept = np.delete(np.arange(recorded.plan.n_samples), [700, 701])
    found = align(replace(recorded.log, joint_states=rows(replace(states, position=position), kept)), recorded.plan)
    np.testing.assert_array_equal(found.numbers, np.arange(recorded.plan.n_samples))
    for lost, around in ((5, [3, 4, 6, 7]), (700, [698, 699, 702, 703]), (701, [698, 699, 702, 703])):
        cubic = BarycentricInterpolator(around, np.asarray(states.position)[around])
        np.testing.assert_allclose(found.position[lost], cubic(lost), rtol=1e-12)
    (warning,) = found.warnings
    assert "3 samples of joint_states are missing or not finite" in warning


def test_position_that_is_never_finite_is_refused(recorded: Recorded) -> None:
    states = recorded.log.joint_states
    with pytest.raises(InputError, match=r"joint_states\.position of the log is not finite in any sample"):
        align(replace(recorded.log, joint_states=replace(states, position=np.nan * states.position)), recorded.plan)


def test_foreign_joints_are_taken_in_their_order_with_a_warning(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_commands is not None
    commands = replace(log.joint_commands, names=("b", "a"), effort=log.joint_commands.effort[:, ::-1].copy())
    found = align(
        replace(log, joint_states=replace(log.joint_states, names=("a", "b")), joint_commands=commands), recorded.plan
    )
    np.testing.assert_array_equal(found.torque, log.joint_commands.effort)
    assert found.names == ("a", "b")
    (warning,) = found.warnings
    assert "a, b are taken for motor_1, motor_2" in warning


def test_too_few_joints_are_refused(recorded: Recorded) -> None:
    states = recorded.log.joint_states
    assert states.position is not None
    one = JointSeries(states.stamp, ("motor_1",), position=states.position[:, :1].copy())
    with pytest.raises(InputError, match="joint_states of the log has 1 joints .*the plan has 2 motors"):
        align(replace(recorded.log, joint_states=one), recorded.plan)


def test_commands_between_the_measurements_are_refused(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_commands is not None
    with pytest.raises(InputError, match="joint_commands is stamped .* the sampling instant"):
        align(with_commands(log, stamp=log.joint_commands.stamp + 200_000), recorded.plan)


def test_slower_commands_are_unequal_rates(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_commands is not None
    with pytest.raises(
        InputError, match="unequal rates: joint_states is sampled at 2000 Hz and joint_commands at 1000 Hz"
    ):
        align(replace(log, joint_commands=rows(log.joint_commands, slice(None, None, 2))), recorded.plan)


def test_slower_reference_is_taken_as_unknown(recorded: Recorded) -> None:
    log = recorded.log
    assert log.joint_reference is not None
    found = align(replace(log, joint_reference=rows(log.joint_reference, slice(None, None, 8))), recorded.plan)
    assert found.reference is None
    (warning,) = found.warnings
    assert "joint_reference is missing in some samples" in warning
