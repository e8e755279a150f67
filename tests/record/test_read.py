"""A log read onto an even grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log, PoseSeries
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.record.stamp_jitter import slight_last
from flexros.record.topic_reader import TorqueSource
from flexros.robot import Robot, load_robot

N = 3000
T = 1e-3
ONE = ("motor_1",)


@pytest.fixture(scope="module")
def emps() -> Robot:
    return load_robot("emps")


def motion(time: np.ndarray) -> np.ndarray:
    return 0.05 * np.sin(2 * np.pi * 1.3 * time) + 0.01 * np.sin(2 * np.pi * 7 * time)


def column(seed: int, n: int = N) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(n, 1))


def make_log(**changes: object) -> Log:
    stamp = stamps_ns(N, T)
    states = JointSeries(stamp, ONE, position=motion(np.arange(N) * T)[:, None])
    return replace(Log(states, JointSeries(stamp, ONE, effort=column(2))), **changes)


def two_columns(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(N, 2))


def log_of_two() -> Log:
    stamp, names = stamps_ns(N, T), ("motor_1", "motor_2")
    return Log(JointSeries(stamp, names, position=two_columns(1)), JointSeries(stamp, names, effort=two_columns(2)))


def read(log: Log, robot: Robot, torque: TorqueSource = "command") -> Record:
    return read_record(log, robot, name="log", torque=torque)


def test_log_of_the_contract_is_taken_as_it_is(emps: Robot) -> None:
    log = make_log(provenance={"scenario": {"name": "x"}})
    record = read(log, emps)
    assert record.sample_time == T
    np.testing.assert_array_equal(record.position, log.joint_states.position)
    np.testing.assert_array_equal(record.torque, log.joint_commands.effort)
    assert record.valid.all()
    assert record.simulated
    assert not record.measured_torque
    assert record.reference is None
    assert record.tool is None
    assert record.warnings == ()


def test_joints_are_matched_by_name() -> None:
    elbow = load_robot("elbow")
    stamp = stamps_ns(N, T)
    values = np.random.default_rng(1).normal(size=(N, 3))
    names = ("gripper", "motor_2", "motor_1")
    log = Log(JointSeries(stamp, names, position=values), JointSeries(stamp, names, effort=values))
    np.testing.assert_array_equal(read(log, elbow).position, values[:, [2, 1]])


def test_foreign_names_are_taken_by_their_numbers_with_a_warning() -> None:
    elbow = load_robot("elbow")
    stamp = stamps_ns(N, T)
    values = np.random.default_rng(1).normal(size=(N, 2))
    names = ("joint_a2", "joint_a1")
    log = Log(JointSeries(stamp, names, position=values), JointSeries(stamp, names, effort=values))
    record = read(log, elbow)
    np.testing.assert_array_equal(record.torque, values[:, [1, 0]])
    assert "joint_a1, joint_a2 are taken for motor_1, motor_2" in record.warnings[0]


def test_foreign_names_of_commands_are_matched_to_those_of_the_states() -> None:
    elbow = load_robot("elbow")
    stamp = stamps_ns(N, T)
    values = np.random.default_rng(1).normal(size=(N, 2))
    states = JointSeries(stamp, ("lift", "swing"), position=values)
    record = read(Log(states, JointSeries(stamp, ("swing", "lift"), effort=values)), elbow)
    np.testing.assert_array_equal(record.torque, values[:, ::-1])
    assert len(record.warnings) == 1


def test_too_few_joints_are_refused() -> None:
    with pytest.raises(InputError, match=r"^log: joint_states has 1 joints \(motor_1\), but robot elbow has 2 motors"):
        read(make_log(), load_robot("elbow"))


def test_measured_torque_stands_in_for_the_command(emps: Robot) -> None:
    log = make_log(joint_commands=None)
    effort = column(3)
    record = read(replace(log, joint_states=replace(log.joint_states, effort=effort)), emps)
    assert record.measured_torque
    np.testing.assert_allclose(record.torque[:-1], (effort[1:] + effort[:-1]) / 2)
    assert any("no joint_commands" in text for text in record.warnings)


def test_position_commands_are_commands_without_torques(emps: Robot) -> None:
    log = make_log()
    commands = JointSeries(log.joint_states.stamp, ONE, position=log.joint_states.position)
    states = replace(log.joint_states, effort=column(3))
    record = read(replace(log, joint_states=states, joint_commands=commands), emps)
    assert any("no commanded torques (effort of joint_commands)" in text for text in record.warnings)


def test_command_goes_before_the_measured_torque_with_a_note(emps: Robot) -> None:
    log = make_log()
    record = read(replace(log, joint_states=replace(log.joint_states, effort=column(3))), emps)
    np.testing.assert_array_equal(record.torque, column(2))
    assert any("has measured torques too; the commanded torques are used" in text for text in record.warnings)


def test_measured_torque_is_used_where_it_is_wanted(emps: Robot) -> None:
    log = make_log()
    effort = column(3)
    record = read(replace(log, joint_states=replace(log.joint_states, effort=effort)), emps, "measured")
    assert record.measured_torque
    np.testing.assert_array_equal(record.noted, effort)
    np.testing.assert_allclose(record.torque[:-1], (effort[1:] + effort[:-1]) / 2)
    assert record.warnings == ()


def test_command_stands_in_for_the_measured_torque(emps: Robot) -> None:
    record = read(make_log(), emps, "measured")
    assert not record.measured_torque
    np.testing.assert_array_equal(record.torque, column(2))
    assert any("joint_states has no measured torques" in text for text in record.warnings)


@pytest.mark.parametrize("torque", ["command", "measured"])
def test_copy_of_the_command_is_no_measurement(emps: Robot, torque: TorqueSource) -> None:
    log = make_log()
    record = read(replace(log, joint_states=replace(log.joint_states, effort=column(2))), emps, torque)
    assert not record.measured_torque
    assert any("is a copy of the commands" in text for text in record.warnings)


def test_a_copy_of_the_commands_is_none_where_a_motor_is_prescribed() -> None:
    log = log_of_two()
    log = replace(log, joint_states=replace(log.joint_states, effort=two_columns(2)))
    record = read_record(log, load_robot("elbow"), name="log", torque="measured", prescribed=("motor_2",))
    assert not record.measured_torque


@pytest.mark.parametrize("lost", [slice(1500, 1501), slice(0, 4)])
def test_a_command_that_is_no_number_is_a_lost_one(emps: Robot, lost: slice) -> None:
    """Commands have stamps of their own: one that is lost must not spoil all later ones."""
    log = make_log()
    assert log.joint_commands is not None
    commands = replace(log.joint_commands, stamp=log.joint_commands.stamp + 100_000, effort=column(2))
    commands.effort[lost] = np.nan
    record = read(replace(log, joint_commands=commands), emps)
    assert np.isfinite(record.torque).all()
    assert np.count_nonzero(record.valid) > N - 10


def test_measured_speeds_are_read_beside_the_positions(emps: Robot) -> None:
    log, speed = make_log(), column(5)
    speed[7] = np.nan
    velocity = read(replace(log, joint_states=replace(log.joint_states, velocity=speed)), emps).velocity
    np.testing.assert_array_equal(velocity[8:], speed[8:])
    assert velocity[7, 0] == speed[6, 0]


def test_speeds_of_one_motor_alone_are_read_and_the_other_is_unknown() -> None:
    log, speed = log_of_two(), two_columns(5)
    speed[:, 0] = np.nan
    speed[7, 1] = np.nan
    velocity = read(replace(log, joint_states=replace(log.joint_states, velocity=speed)), load_robot("elbow")).velocity
    assert velocity is not None
    assert np.isnan(velocity[:, 0]).all()
    np.testing.assert_array_equal(np.delete(velocity[:, 1], 7), np.delete(speed[:, 1], 7))
    assert velocity[7, 1] == speed[6, 1]


@pytest.mark.parametrize("torque", ["command", "measured"])
def test_torques_measured_at_one_motor_alone_do_not_count_as_those_that_acted(torque: TorqueSource) -> None:
    log, effort = log_of_two(), two_columns(5)
    effort[:, 0] = np.nan
    states = replace(log.joint_states, effort=effort)
    record = read(replace(log, joint_states=states), load_robot("elbow"), torque)
    assert not record.measured_torque
    assert record.valid.all()
    np.testing.assert_array_equal(record.torque, two_columns(2))
    with pytest.raises(InputError, match="no measured torque .* of motor_1, and there are no commanded"):
        read(replace(log, joint_states=states, joint_commands=None), load_robot("elbow"), torque)


def test_the_motion_of_a_motor_without_torque_is_prescribed_where_that_is_allowed() -> None:
    log, effort = log_of_two(), two_columns(5)
    effort[:, 0] = np.nan
    log = replace(log, joint_states=replace(log.joint_states, effort=effort), joint_commands=None)
    record = read_record(log, load_robot("elbow"), name="log", prescribed=())
    assert record.prescribed == (0,)
    assert record.predicted.tolist() == [False, True]
    assert record.valid.all()
    np.testing.assert_array_equal(record.torque[:-1, 1], 0.5 * (effort[:-1, 1] + effort[1:, 1]))
    assert any("the measured motion of motor_1 drives the model there, since no torque" in t for t in record.warnings)


def test_torques_of_motors_whose_motion_is_to_be_prescribed_do_not_count() -> None:
    log, commands = log_of_two(), two_columns(2)
    commands[::3, 1] = np.nan
    log = replace(log, joint_commands=replace(log.joint_commands, effort=commands))
    record = read_record(log, load_robot("elbow"), name="log", prescribed=("motor_2",))
    assert record.prescribed == (1,)
    assert record.valid.all()
    np.testing.assert_array_equal(record.torque[:, 0], commands[:, 0])
    with pytest.raises(InputError, match="motor 'motor_3'"):
        read_record(log, load_robot("elbow"), name="log", prescribed=("motor_3",))
    with pytest.raises(InputError, match="the motion of every motor would be prescribed"):
        read_record(log, load_robot("elbow"), name="log", prescribed=("motor_1", "motor_2"))


def test_no_torque_is_refused(emps: Robot) -> None:
    with pytest.raises(InputError, match="^log has neither commanded torques .* nor measured ones"):
        read(make_log(joint_commands=None), emps)


def test_no_position_is_refused(emps: Robot) -> None:
    with pytest.raises(InputError, match="^log: joint_states has no positions"):
        read(make_log(joint_states=JointSeries(stamps_ns(N, T), ONE)), emps)


def test_commands_of_a_lower_rate_are_held(emps: Robot) -> None:
    stamp = stamps_ns(N // 4, 4 * T)
    record = read(make_log(joint_commands=JointSeries(stamp, ONE, effort=column(4, N // 4))), emps)
    np.testing.assert_allclose(record.torque[:, 0], np.repeat(column(4, N // 4)[:, 0], 4), atol=1e-9)
    assert record.valid.all()


def test_command_that_comes_within_a_sample_acts_for_the_rest(emps: Robot) -> None:
    stamp = stamps_ns(N, T) + 250_000
    u = column(2)
    record = read(make_log(joint_commands=JointSeries(stamp, ONE, effort=u)), emps)
    np.testing.assert_allclose(record.torque, 0.25 * u[:-1] + 0.75 * u[1:], atol=1e-9)
    np.testing.assert_array_equal(record.position, make_log().joint_states.position[1:])


def test_record_begins_with_the_first_command_and_ends_with_the_last(emps: Robot) -> None:
    stamp = stamps_ns(N, T)[100:-50]
    record = read(make_log(joint_commands=JointSeries(stamp, ONE, effort=column(2)[100:-50])), emps)
    np.testing.assert_array_equal(record.torque, column(2)[100:-50])
    np.testing.assert_array_equal(record.position, make_log().joint_states.position[100:-50])


def test_lost_measurements_are_held_and_marked(emps: Robot) -> None:
    keep = np.ones(N, dtype=bool)
    keep[[500, 501, 900]] = False
    log = make_log()
    states = JointSeries(log.joint_states.stamp[keep], ONE, position=log.joint_states.position[keep])
    record = read(replace(log, joint_states=states), emps)
    np.testing.assert_array_equal(record.valid, keep)
    assert record.position[501, 0] == log.joint_states.position[499, 0]
    np.testing.assert_array_equal(record.torque, column(2))
    assert any("3 of 3000 samples are missing" in text for text in record.warnings)


def test_short_hole_of_commands_is_held_and_a_long_one_does_not_count(emps: Robot) -> None:
    keep = np.ones(N, dtype=bool)
    keep[500:503], keep[1000:1100] = False, False
    stamp = stamps_ns(N, T)[keep]
    record = read(make_log(joint_commands=JointSeries(stamp, ONE, effort=column(2)[keep])), emps)
    assert record.valid[495:510].all()
    np.testing.assert_array_equal(record.torque[500:503, 0], column(2)[[499, 499, 499], 0])
    assert not record.valid[1010:1100].any()
    assert any("103 samples have no command of their own" in text for text in record.warnings)


def test_values_that_are_not_finite_do_not_count(emps: Robot) -> None:
    log = make_log()
    position = log.joint_states.position.copy()
    position[10:20] = np.nan
    record = read(replace(log, joint_states=replace(log.joint_states, position=position)), emps)
    assert not record.valid[10:20].any()
    assert np.isfinite(record.position).all()


def test_mostly_missing_is_refused(emps: Robot) -> None:
    log = make_log()
    position = log.joint_states.position.copy()
    position[: N // 2] = np.nan
    with pytest.raises(InputError, match=r"^log: 1500 of 3000 samples are missing or not finite \(first at sample 0\)"):
        read(replace(log, joint_states=replace(log.joint_states, position=position)), emps)


def test_pauses_between_experiments_do_not_count_as_lost(emps: Robot) -> None:
    log = make_log()
    keep = np.arange(N) % 1000 < 400
    states, commands = log.joint_states, log.joint_commands
    assert commands is not None
    short = replace(
        log,
        joint_states=replace(states, stamp=states.stamp[keep], position=states.position[keep]),
        joint_commands=replace(commands, stamp=commands.stamp[keep], effort=commands.effort[keep]),
    )
    record = read(short, emps)
    np.testing.assert_array_equal(record.valid, keep[: record.n_samples])
    assert any("pauses 2 times" in text for text in record.warnings)


@pytest.mark.parametrize("true_instants", [True, False])
def test_jitter_is_undone_where_the_stamps_tell_the_true_instants(emps: Robot, true_instants: bool) -> None:
    rng = np.random.default_rng(5)
    off = 1e-4 * rng.normal(size=N)
    off[0] = 0
    time = np.arange(N) * T
    measured = motion(time + off if true_instants else time) + 1e-6 * rng.normal(size=N)
    stamp = stamps_ns(N, T) + np.rint(off * 1e9).astype(np.int64)
    record = read(make_log(joint_states=JointSeries(stamp, ONE, position=measured[:, None])), emps)
    start = (stamps_ns(N, T)[0] - stamp[0]) * 1e-9
    error = record.position[:, 0] - motion(np.arange(record.n_samples) * T - start)
    assert np.sqrt(np.mean(error[5:-5] ** 2)) < 6e-6
    text = "are the true instants; the positions were interpolated" if true_instants else "do not follow"
    assert any(text in warning for warning in record.warnings)


def test_jitter_that_does_not_matter_is_told_once_and_last(emps: Robot) -> None:
    texts = []
    for seed in (1, 2):
        off = np.random.default_rng(seed).normal(scale=1e5, size=N).astype(np.int64)
        states = JointSeries(stamps_ns(N, T) + off, ONE, position=motion(np.arange(N) * T)[:, None])
        texts += read(make_log(joint_states=states), emps).warnings
    assert all("treated as even" in text for text in texts)
    assert len(set(texts)) == 2
    assert slight_last((texts[0], "a torque is missing", f"held-out log: {texts[1]}")) == (
        "a torque is missing",
        texts[0],
    )


@pytest.mark.parametrize("true_instants", [True, False])
def test_velocities_show_a_rate_that_changes_slowly(emps: Robot, true_instants: bool) -> None:
    """Second differences of the positions do not."""
    time = np.arange(N) * T
    off = 0.02 * np.sin(2 * np.pi * time / time[-1])
    at = time + off if true_instants else time
    measured = motion(at) + 1e-6 * np.random.default_rng(5).normal(size=N)
    stamp = stamps_ns(N, T) + np.rint(off * 1e9).astype(np.int64)
    speed = np.gradient(motion(at), at)
    states = JointSeries(stamp, ONE, position=measured[:, None], velocity=speed[:, None])
    record = read(make_log(joint_states=states), emps)
    text = "are the true instants; the positions were interpolated" if true_instants else "do not follow"
    assert any(text in warning for warning in record.warnings)


def test_reference_of_a_lower_rate_is_interpolated(emps: Robot) -> None:
    stamp = stamps_ns(N // 4 + 1, 4 * T)
    ramp = np.arange(N // 4 + 1)[:, None] * 4.0
    record = read(make_log(joint_reference=JointSeries(stamp, ONE, position=ramp)), emps)
    np.testing.assert_allclose(record.reference[:, 0], np.arange(N), atol=1e-6)


def test_reference_stands_at_its_samples_where_messages_share_an_instant(emps: Robot) -> None:
    rows = np.sort(np.append(np.arange(N), [100, 1000]))
    again = np.append(False, rows[1:] == rows[:-1])
    stamp, ramp = stamps_ns(N, T)[rows] + 200_000 * again, rows + 0.5 * again
    states = JointSeries(stamp, ONE, position=motion(rows * T)[:, None])
    record = read(make_log(joint_states=states, joint_reference=JointSeries(stamp, ONE, position=ramp[:, None])), emps)
    np.testing.assert_array_equal(record.reference[:, 0], np.arange(N))


def test_reference_that_ends_early_is_unknown(emps: Robot) -> None:
    stamp = stamps_ns(N // 2, T)
    record = read(make_log(joint_reference=JointSeries(stamp, ONE, position=column(1, N // 2))), emps)
    assert record.reference is None
    assert any("joint_reference covers 50 % of the log" in text for text in record.warnings)


def test_tool_keeps_its_own_rate_and_counts_time_from_the_first_sample(emps: Robot) -> None:
    stamp = stamps_ns(N // 3, 3 * T) + 700_000
    position = np.random.default_rng(1).normal(size=(N // 3, 3))
    tool = PoseSeries(stamp, "base", position, np.tile([0.0, 0, 0, 1], (N // 3, 1)))
    record = read(make_log(tool_pose=tool, joint_commands=make_log().joint_commands), emps)
    np.testing.assert_allclose(record.tool.time[:3], [0.0007, 0.0037, 0.0067], atol=1e-9)
    np.testing.assert_array_equal(record.tool.position, position[: len(record.tool.time)])


def test_commands_elsewhere_in_time_are_refused(emps: Robot) -> None:
    stamp = stamps_ns(N, T) + 10_000_000_000
    with pytest.raises(InputError, match="^log: no measurement is between the first and the last command"):
        read(make_log(joint_commands=JointSeries(stamp, ONE, effort=column(2))), emps)


def test_log_with_more_motors_than_the_robot_is_refused(emps: Robot) -> None:
    stamp = stamps_ns(N, T)
    values = np.random.default_rng(1).normal(size=(N, 2))
    names = ("motor_1", "motor_2")
    log = Log(JointSeries(stamp, names, position=values), JointSeries(stamp, names, effort=values))
    with pytest.raises(
        InputError, match=r"^log: joint_states has the motors motor_1, motor_2, but robot emps has 1 \(motor_1\)"
    ):
        read(log, emps)


def test_irregular_samples_are_resampled_by_their_true_times(emps: Robot) -> None:
    stamp = np.rint(2e6 * np.rint(np.arange(N) * 10.66e-3 / 2e-3)).astype(np.int64) + 10**9
    time = (stamp - 10**9) * 1e-9
    position = 0.05 * np.sin(2 * np.pi * 1.3 * time)[:, None]
    states = JointSeries(stamp, ONE, position=position, velocity=position.copy(), effort=3 * position)
    record = read(Log(states, provenance={"import": {}}), emps)
    at = np.arange(record.n_samples) * record.sample_time
    wanted = 0.05 * np.sin(2 * np.pi * 1.3 * (at + np.median(time - 10.66e-3 * np.arange(N))))
    assert record.valid.mean() > 0.999
    assert np.abs(record.position[:, 0] - wanted)[2:-2].max() < 2e-4
    assert np.abs(record.velocity[:, 0] - wanted)[2:-2].max() < 4e-4
    mean = 3 * (wanted[:-1] + wanted[1:]) / 2
    assert np.abs(record.torque[:-1, 0] - mean)[2:-2].max() < 1.5e-3
    assert any("are irregular (10 to 12 ms apart" in text for text in record.warnings)
