"""Foreign logs become logs of the contract."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from flexros.errors import InputError
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.logs.reader import read_log
from flexros.logs.write_log import write_log

REALDATA = os.environ.get("FLEXROS_REALDATA", "")
NEEDS_EMPS = pytest.mark.skipif(
    not (Path(REALDATA) / "emps").is_dir() or not REALDATA,
    reason="FLEXROS_REALDATA is unset or names no folder with emps/, the measured drive",
)
Q = {"column": "q", "quantity": "position", "unit": "rad"}
U = {"column": "u", "quantity": "torque_command", "unit": "Nm"}
R = {"column": "r", "quantity": "reference_position", "unit": "deg"}


def test_columns_become_topics_in_si_units(mapping_of, table, write_csv, tmp_path: Path) -> None:
    log = import_log(mapping_of(Q, {**U, "sign": -1, "offset": 0.5}, R), [write_csv(tmp_path / "a.csv", table)])
    np.testing.assert_array_equal(log.joint_states.position[:, 0], table["q"])
    np.testing.assert_allclose(log.joint_commands.effort[:, 0], 0.5 - table["u"])
    np.testing.assert_allclose(log.joint_reference.position[:, 0], np.deg2rad(table["r"]))
    assert log.joint_states.stamp[0] == 10**9
    assert np.all(np.diff(log.joint_states.stamp) == 10**6)


def test_csv_matlab_and_numpy_give_the_same_log(mapping_of, table, write_csv, tmp_path: Path, assert_same_log) -> None:
    mapping = mapping_of(Q, U, R)
    savemat(tmp_path / "a.mat", table)
    np.savez(tmp_path / "a.npz", **table)
    write_csv(tmp_path / "a.csv", table)
    logs = [import_log(mapping, [tmp_path / name]) for name in ("a.csv", "a.mat", "a.npz")]
    assert_same_log(logs[0], logs[1])
    assert_same_log(logs[0], logs[2])


def test_written_log_is_read_again(mapping_of, table, write_csv, tmp_path: Path, assert_same_log) -> None:
    log = import_log(mapping_of(Q, U), [write_csv(tmp_path / "drive.csv", table)])
    write_log(log, tmp_path / "bag")
    again = read_log(tmp_path / "bag")
    assert_same_log(log, again)
    assert again.warnings == ()
    assert again.provenance["import"]["mapping"]["name"] == "mine"
    assert again.provenance["import"]["files"][0]["name"] == "drive.csv"
    assert len(again.provenance["import"]["files"][0]["sha256"]) == 64


def test_rate_instead_of_a_time_column(mapping_of, table, write_csv, tmp_path: Path) -> None:
    log = import_log(mapping_of(Q, time={"rate": 250}), [write_csv(tmp_path / "a.csv", table)])
    assert log.joint_states.stamp[-1] - log.joint_states.stamp[0] == 49 * 4_000_000


def test_time_offset_moves_the_stamps_of_a_topic(mapping_of, table, write_csv, tmp_path: Path) -> None:
    log = import_log(mapping_of(Q, {**U, "time_offset": -0.0005}), [write_csv(tmp_path / "a.csv", table)])
    assert log.joint_commands.stamp[0] - log.joint_states.stamp[0] == -500_000
    assert log.joint_commands.stamp[0] == 10**9


def test_quantities_of_one_topic_with_unequal_times_are_interpolated(mapping_of, write_csv, tmp_path: Path) -> None:
    t = np.arange(20) * 0.01
    effort = {"column": "m", "quantity": "measured_torque", "unit": "Nm", "time_offset": 0.004}
    file = write_csv(tmp_path / "a.csv", {"t": t, "q": t, "m": 3 * (t + 0.004)})
    log = import_log(mapping_of(Q, effort), [file])
    np.testing.assert_allclose(log.joint_states.effort, 3 * log.joint_states.position, rtol=1e-12)
    assert len(log.joint_states.stamp) == 19
    assert "measured_torque of motor_1 was interpolated linearly" in log.warnings[0]


def test_columns_in_several_files(mapping_of, table, write_csv, tmp_path: Path) -> None:
    q = write_csv(tmp_path / "q.csv", {"t": table["t"], "q": table["q"]})
    u = write_csv(tmp_path / "u.csv", {"t": table["t"][::2], "u": table["u"][::2]})
    log = import_log(mapping_of(Q, U), [q, u])
    assert len(log.joint_states.stamp) == 50
    assert len(log.joint_commands.stamp) == 25


def test_same_column_in_several_files_needs_the_key_file(mapping_of, table, write_csv, tmp_path: Path) -> None:
    files = [
        write_csv(tmp_path / name, {"t": table["t"], "q": table[key]}) for name, key in (("a.csv", "q"), ("b.csv", "u"))
    ]
    with pytest.raises(InputError, match="column 'q' is in several files .a.csv, b.csv.; add the key 'file'"):
        import_log(mapping_of(Q), files)
    log = import_log(mapping_of({**Q, "file": "a*"}, {**U, "column": "q", "file": "b*"}), files)
    np.testing.assert_array_equal(log.joint_commands.effort[:, 0], table["u"])


def test_two_joints_of_a_matrix(mapping_of, tmp_path: Path) -> None:
    q = np.arange(20.0).reshape(10, 2)
    np.savez(tmp_path / "a.npz", t=np.arange(10) * 1e-3, q=q)
    columns = [{**Q, "column": f"q[{k}]", "joint": f"motor_{2 - k}"} for k in (0, 1)]
    log = import_log(mapping_of(*columns), [tmp_path / "a.npz"])
    assert log.joint_states.names == ("motor_1", "motor_2")
    np.testing.assert_array_equal(log.joint_states.position, q[:, ::-1])


def test_positions_of_an_encoder_that_begins_again_go_on(mapping_of, tmp_path: Path) -> None:
    """As the -12.5 to 12.5 rad of some drives; a lost sample stays one."""
    turned = np.linspace(0.0, 40.0, 200)
    turned[70] = np.nan
    np.savez(tmp_path / "a.npz", t=np.arange(200) * 1e-2, q=np.mod(turned + 12.5, 25.0) - 12.5)
    log = import_log(mapping_of({**Q, "period": 25.0}), [tmp_path / "a.npz"])
    np.testing.assert_allclose(log.joint_states.position[:, 0], turned, atol=1e-9)
    with pytest.raises(InputError, match="leave out the key 'period'"):
        mapping_of({"column": "v", "quantity": "velocity", "unit": "rad/s", "period": 25.0})


def test_optional_column_may_be_missing(mapping_of, table, write_csv, tmp_path: Path) -> None:
    log = import_log(mapping_of(Q, {**U, "column": "x", "optional": True}), [write_csv(tmp_path / "a.csv", table)])
    assert log.joint_commands is None
    assert log.warnings == ("optional column 'x' is in none of the files",)


def test_unknown_column_lists_those_there_are(mapping_of, table, write_csv, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        import_log(mapping_of({**Q, "column": "qq"}), [write_csv(tmp_path / "a.csv", table)])
    assert "unknown column of mapping mine 'qq' in" in str(caught.value)
    assert "did you mean 'q'? allowed are q, r, t, u" in str(caught.value)


def test_unknown_time_column(mapping_of, table, write_csv, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown time column of mapping mine 'time' in .*allowed are q, r, t, u"):
        import_log(mapping_of(Q, time={"column": "time"}), [write_csv(tmp_path / "a.csv", table)])


def test_file_without_any_of_the_columns(mapping_of, table, write_csv, tmp_path: Path) -> None:
    files = [write_csv(tmp_path / "a.csv", table), write_csv(tmp_path / "b.csv", {"x": table["t"]})]
    with pytest.raises(InputError, match="b.csv has none of the columns of mapping mine; leave the file out"):
        import_log(mapping_of(Q), files)


def test_time_that_goes_back_is_refused_with_its_row(mapping_of, table, write_csv, tmp_path: Path) -> None:
    table["t"][7] = 0.0055
    told = "time column 't', row 8: the time goes back .0.006 s, then 0.0055 s.*are broken"
    with pytest.raises(InputError, match=told):
        import_log(mapping_of(Q), [write_csv(tmp_path / "a.csv", table)])


@pytest.mark.parametrize("suffix", [".csv", ".mat", ".npz"])
def test_a_value_that_is_not_finite_is_a_lost_sample(mapping_of, table, write_csv, tmp_path: Path, suffix) -> None:
    table["q"][[4, 9]] = np.nan
    table["u"][9] = np.inf
    file = tmp_path / f"a{suffix}"
    {".csv": write_csv, ".mat": savemat, ".npz": lambda path, columns: np.savez(path, **columns)}[suffix](file, table)
    log = import_log(mapping_of(Q, {**Q, "joint": "motor_2"}, U), [file])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(log.joint_states.position).any(axis=1)), [4, 9])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(log.joint_commands.effort[:, 0])), [9])
    assert len(log.joint_states.stamp) == 50
    positions, torques = log.warnings
    for told in ("2 of 50 rows", " of q (first: row 5)"):
        assert told in positions
    for told in ("1 of 50 rows", " of u (first: row 10)"):
        assert told in torques


def test_an_empty_cell_is_a_lost_sample(mapping_of, table, write_csv, tmp_path: Path) -> None:
    file = write_csv(tmp_path / "a.csv", table)
    lines = file.read_text().splitlines()
    lines[6] = ",".join([lines[6].split(",")[0], "", *lines[6].split(",")[2:]])
    file.write_text("\n".join(lines))
    log = import_log(mapping_of(Q, U), [file])
    assert np.flatnonzero(np.isnan(log.joint_states.position[:, 0])).tolist() == [5]
    assert "1 of 50 rows" in log.warnings[0]


def test_lost_samples_are_written_and_read_again(mapping_of, table, write_csv, tmp_path: Path, assert_same_log) -> None:
    table["q"][4] = np.nan
    log = import_log(mapping_of(Q, U), [write_csv(tmp_path / "a.csv", table)])
    write_log(log, tmp_path / "bag")
    assert_same_log(log, read_log(tmp_path / "bag"))


def test_a_repeated_time_keeps_the_first_row(mapping_of, table, write_csv, tmp_path: Path) -> None:
    table["t"][[7, 8, 20]] = table["t"][[6, 6, 19]]
    log = import_log(mapping_of(Q, U), [write_csv(tmp_path / "a.csv", table)])
    kept = np.delete(np.arange(50), [7, 8, 20])
    np.testing.assert_array_equal(log.joint_states.position[:, 0], table["q"][kept])
    np.testing.assert_array_equal(log.joint_commands.effort[:, 0], table["u"][kept])
    (text,) = log.warnings
    assert "time column 't' repeats" in text
    assert "in 3 of 50 rows (first: row 8)" in text


def test_a_row_without_a_time_is_left_out(mapping_of, table, write_csv, tmp_path: Path) -> None:
    table["t"][7] = np.nan
    log = import_log(mapping_of(Q), [write_csv(tmp_path / "a.csv", table)])
    np.testing.assert_array_equal(log.joint_states.position[:, 0], np.delete(table["q"], 7))
    assert "in 1 of 50 rows (first: row 8)" in log.warnings[0]


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ("q", r"column 'q' \(position of motor_1\) is not finite in 20 of 50 rows \(first: row 11\)"),
        ("t", r"time column 't' has no finite time in 20 of 50 rows \(first: row 11\)"),
    ],
)
def test_a_large_part_that_is_not_finite_is_refused(mapping_of, table, write_csv, tmp_path, column, message) -> None:
    table[column][10:30] = np.nan
    with pytest.raises(InputError, match=message):
        import_log(mapping_of(Q), [write_csv(tmp_path / "a.csv", table)])


def test_a_column_without_values_is_refused_by_its_name(mapping_of, table, write_csv, tmp_path: Path) -> None:
    table["u"][:] = np.nan
    with pytest.raises(InputError, match=r"column 'u' \(torque_command of motor_1\) has no finite value in 50 rows"):
        import_log(mapping_of(Q, U), [write_csv(tmp_path / "a.csv", table)])


def test_times_too_coarse_for_the_rows_are_refused(mapping_of, table, write_csv, tmp_path: Path) -> None:
    table["t"] = np.floor(table["t"] / 0.005) * 0.005
    with pytest.raises(InputError, match=r"time column 't' repeats .* 40 of 50 rows .*rate: HZ"):
        import_log(mapping_of(Q), [write_csv(tmp_path / "a.csv", table)])


def test_lost_positions_of_a_motor_are_lost_beyond_it(mapping_of, table, write_csv, tmp_path: Path) -> None:
    table["q"][4] = np.nan
    deflection = {"column": "u", "quantity": "link_deflection", "unit": "mrad"}
    axes = [{"column": "q", "quantity": "tool_acceleration", "axis": axis, "unit": "mm/s2"} for axis in "xyz"]
    log = import_log(mapping_of(Q, deflection, *axes), [write_csv(tmp_path / "a.csv", table)])
    assert np.flatnonzero(np.isnan(log.series("link_states").position[:, 0])).tolist() == [4]
    assert any("must contain gravity" in text for text in log.warnings)


def test_unequal_lengths(mapping_of, table, tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=table["t"][:-1], q=table["q"])
    with pytest.raises(InputError, match="column 'q' has 50 rows, but its time 't' of .* has 49; make them"):
        import_log(mapping_of(Q), [tmp_path / "a.npz"])


def test_too_few_rows(mapping_of, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,q\n0,1\n")
    with pytest.raises(InputError, match="has 1 rows, but at least 2 are needed"):
        import_log(mapping_of(Q), [tmp_path / "a.csv"])


TWO = [Q, {**Q, "column": "r", "joint": "motor_2"}]


def test_a_joint_that_lacks_a_quantity_has_no_values_of_it(mapping_of, table, write_csv, tmp_path, assert_same_log):
    velocity = {"column": "u", "quantity": "velocity", "unit": "rad/s", "joint": "motor_2"}
    link = {"column": "q", "quantity": "link_position", "unit": "rad"}
    torque = {"column": "u", "quantity": "joint_torque", "unit": "Nm", "joint": "motor_2"}
    log = import_log(mapping_of(*TWO, velocity, link, torque), [write_csv(tmp_path / "a.csv", table)])
    nothing = np.full(50, np.nan)
    np.testing.assert_array_equal(log.joint_states.velocity, np.column_stack([nothing, table["u"]]))
    sensors = log.series("link_states")
    assert sensors.names == ("motor_1", "motor_2")
    np.testing.assert_array_equal(sensors.position, np.column_stack([table["q"], nothing]))
    np.testing.assert_array_equal(sensors.effort, np.column_stack([nothing, table["u"]]))
    write_log(log, tmp_path / "bag")
    assert_same_log(log, read_log(tmp_path / "bag"))


@pytest.mark.parametrize(("drive", "unit"), [("torque_command", "Nm"), ("position_command", "rad")])
def test_what_drives_the_robot_is_needed_at_all_joints(mapping_of, table, write_csv, tmp_path, drive, unit) -> None:
    rate = {"column": "u", "quantity": "velocity_command", "unit": "rad/s", "joint": "motor_2"}
    mapping = mapping_of(*TWO, {"column": "u", "quantity": drive, "unit": unit}, rate)
    with pytest.raises(InputError, match=f"{drive}, .* for motor_1 but not for motor_2"):
        import_log(mapping, [write_csv(tmp_path / "a.csv", table)])


def test_clocks_without_common_time(mapping_of, table, write_csv, tmp_path: Path) -> None:
    effort = {"column": "m", "quantity": "measured_torque", "unit": "Nm"}
    a = write_csv(tmp_path / "a.csv", {"t": table["t"], "q": table["q"]})
    b = write_csv(tmp_path / "b.csv", {"t": table["t"] + 9, "m": table["u"]})
    with pytest.raises(InputError, match="a.csv, column 'q' and .*b.csv, column 'm' have no time in common"):
        import_log(mapping_of(Q, effort), [a, b])


@NEEDS_EMPS
def test_emps_from_matlab_and_from_csv(write_csv, tmp_path: Path, assert_same_log) -> None:
    file = Path(REALDATA) / "emps" / "DATA_EMPS_PULSES.mat"
    content = loadmat(file, squeeze_me=True)
    columns = {name: content[name][:2000] for name in ("t", "qg", "qm", "vir", "pulses_N")}
    savemat(tmp_path / "part.mat", columns)
    mapping = load_mapping("emps")
    log = import_log(mapping, [tmp_path / "part.mat"])
    assert_same_log(log, import_log(mapping, [write_csv(tmp_path / "part.csv", columns)]))
    np.testing.assert_allclose(log.joint_commands.effort[:, 0], 35.1506 * columns["vir"])
    whole = import_log(mapping, [file])
    assert len(whole.joint_states.stamp) == 24841
    assert whole.joint_reference.effort is not None


def test_joints_of_a_coupled_wrist_are_sums_of_columns(mapping_of, table, write_csv, tmp_path: Path) -> None:
    wrist = {"sum": {"q": 0.5, "r": -0.5}, "quantity": "position", "unit": "deg", "joint": "motor_2"}
    log = import_log(mapping_of(Q, wrist), [write_csv(tmp_path / "a.csv", table)])
    np.testing.assert_allclose(log.joint_states.position[:, 1], np.deg2rad((table["q"] - table["r"]) / 2))


def test_columns_of_a_sum_are_in_one_file(mapping_of, table, write_csv, tmp_path: Path) -> None:
    files = [write_csv(tmp_path / f"{k}.csv", {"t": table["t"], k: table[k]}) for k in ("q", "r")]
    with pytest.raises(InputError, match="q . r of position are in different files"):
        import_log(mapping_of({"sum": {"q": 1, "r": 1}, "quantity": "position", "unit": "rad"}), files)


def test_files_have_clocks_of_their_own(mapping_of, write_csv, tmp_path: Path) -> None:
    time = np.arange(50) * 0.01
    q = write_csv(tmp_path / "q.csv", {"t": time, "q": time})
    u = write_csv(tmp_path / "u.csv", {"stamp": 1e3 * time, "u": time})
    clocks = [{"column": "stamp", "unit": "ms", "file": "u*", "offset": 0.005}, {"column": "t"}]
    log = import_log(mapping_of(Q, U, time=clocks), [q, u])
    assert np.all(log.joint_commands.stamp - log.joint_states.stamp == 5_000_000)


@pytest.mark.parametrize(
    "clock", [{"column": "t"}, {"column": "t", "file": "time.*"}, {"column": "[0]", "file": "*.txt"}]
)
def test_times_are_in_a_file_of_their_own(mapping_of, table, write_csv, tmp_path: Path, clock: dict) -> None:
    files = [tmp_path / name for name in ("q.npz", "u.npz", "time.npz", "time.txt")]
    for file, key in zip(files[:3], "qut", strict=True):
        np.savez(file, **{key: table[key]})
    np.savetxt(files[3], table["t"])
    log = import_log(mapping_of(Q, U, time=clock), [*files[:2], files[3 if clock["column"] == "[0]" else 2]])
    np.testing.assert_array_equal(log.joint_states.position[:, 0], table["q"])
    np.testing.assert_array_equal(log.joint_states.stamp, 10**9 + 10**6 * np.arange(50))
    np.testing.assert_array_equal(log.joint_commands.stamp, log.joint_states.stamp)


def test_files_of_times_must_be_one_of_as_many_rows(mapping_of, table, tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("q.npz", "t1.npz", "t2.npz")]
    np.savez(files[0], q=table["q"])
    for file in files[1:]:
        np.savez(file, t=table["t"][1:])
    with pytest.raises(InputError, match="times of q.npz are in several files .t1.npz, t2.npz.; name one"):
        import_log(mapping_of(Q), files)
    with pytest.raises(InputError, match="q.npz, column 'q' has 50 rows, but its time 't' of .*t1.npz has 49"):
        import_log(mapping_of(Q), files[:2])
    with pytest.raises(InputError, match="unknown time column of mapping mine 'x' in .*t1.npz: allowed are t"):
        import_log(mapping_of(Q, time={"column": "x", "file": "t1*"}), files[:2])


def test_a_column_has_a_clock_of_its_own(mapping_of, write_csv, tmp_path: Path) -> None:
    time = np.arange(50) * 0.01
    file = write_csv(tmp_path / "a.csv", {"t": time, "q": time, "t2": time + 0.002, "u": time})
    log = import_log(mapping_of(Q, {**U, "time": {"column": "t2"}}), [file])
    assert np.all(log.joint_commands.stamp - log.joint_states.stamp == 2_000_000)


def test_sensors_of_link_and_tool_become_their_topics(mapping_of, table, write_csv, tmp_path: Path) -> None:
    columns = [
        Q,
        {"column": "u", "quantity": "link_deflection", "unit": "mrad"},
        {"column": "r", "quantity": "joint_torque", "unit": "Nm"},
        {"column": "q", "quantity": "tool_acceleration", "axis": "y", "unit": "g"},
    ]
    log = import_log(mapping_of(*columns), [write_csv(tmp_path / "a.csv", table)])
    write_log(log, tmp_path / "bag")
    again = read_log(tmp_path / "bag")
    link, imu = again.series("link_states"), again.series("tool_imu")
    np.testing.assert_allclose(link.position[:, 0], table["q"] + 1e-3 * table["u"])
    np.testing.assert_array_equal(link.effort[:, 0], table["r"])
    np.testing.assert_allclose(imu.acceleration[:, 1], 9.80665 * table["q"])
    assert np.isnan(imu.acceleration[:, 0]).all()
    assert imu.turning_rate is None


@pytest.mark.parametrize(
    ("link", "doubt"),
    [({"sign": -1}, "moves against its motor"), ({"unit": "deg"}, "times as far as its motor"), ({}, "")],
)
def test_link_that_moves_unlike_its_motor_is_told(mapping_of, table, write_csv, tmp_path, link, doubt) -> None:
    file = write_csv(tmp_path / "a.csv", {**table, "l": table["q"] + 1e-3})
    entry = {"column": "l", "quantity": "link_position", "unit": "rad", **link}
    warnings = import_log(mapping_of(Q, entry), [file]).warnings
    assert len(warnings) == bool(doubt)
    assert all(doubt in text for text in warnings)


@pytest.mark.parametrize(
    ("factor", "doubt"), [(1.0, ""), (0.5, "is 0.5 times the derivative of its position"), (-1.0, "is opposite")]
)
def test_velocity_that_is_none_of_the_position_is_told(mapping_of, write_csv, tmp_path, factor, doubt) -> None:
    """As of a drive that states half of its speed; noise of the encoder does not hide it."""
    time = np.arange(1000) * 1e-2
    noise = np.random.default_rng(1).normal(size=(2, 1000))
    table = {"t": time, "q": np.sin(2 * time) + 0.01 * noise[0], "v": factor * (2 * np.cos(2 * time) + 0.1 * noise[1])}
    velocity = {"column": "v", "quantity": "velocity", "unit": "rad/s"}
    warnings = import_log(mapping_of(Q, velocity), [write_csv(tmp_path / "a.csv", table)]).warnings
    assert len(warnings) == bool(doubt)
    assert all(doubt in text for text in warnings)


def test_acceleration_without_gravity_is_told(mapping_of, table, write_csv, tmp_path: Path) -> None:
    axes = [{"column": "q", "quantity": "tool_acceleration", "axis": a, "unit": "mm/s2"} for a in "xyz"]
    (text,) = import_log(mapping_of(Q, *axes), [write_csv(tmp_path / "a.csv", table)]).warnings
    assert "must contain gravity" in text


def test_damaged_number_is_refused_with_its_row(mapping_of, table, write_csv, tmp_path: Path) -> None:
    table["q"][6] = 1e200
    with pytest.raises(InputError, match="column 'q', row 7: 1e.200"):
        import_log(mapping_of(Q), [write_csv(tmp_path / "a.csv", table)])


def test_positions_and_speeds_of_servos_are_commands(
    mapping_of, table, write_csv, tmp_path: Path, assert_same_log
) -> None:
    command = {"column": "r", "quantity": "position_command", "unit": "deg"}
    rate = {"column": "u", "quantity": "velocity_command", "unit": "rad/s"}
    log = import_log(mapping_of(Q, command, rate), [write_csv(tmp_path / "a.csv", table)])
    np.testing.assert_allclose(log.joint_commands.position[:, 0], np.deg2rad(table["r"]))
    np.testing.assert_allclose(log.joint_commands.velocity[:, 0], table["u"])
    assert log.joint_commands.effort is None
    write_log(log, tmp_path / "bag")
    assert_same_log(log, read_log(tmp_path / "bag"))


def test_a_file_with_the_same_times_is_not_said_to_be_interpolated(mapping_of, write_csv, tmp_path: Path) -> None:
    """As where one file of a run has a row more: values at its own times are those that were measured."""
    t = np.arange(20) * 0.04
    effort = {"column": "m", "quantity": "measured_torque", "unit": "Nm", "file": "b.csv"}
    files = [
        write_csv(tmp_path / "a.csv", {"t": t, "q": t}),
        write_csv(tmp_path / "b.csv", {"t": t[:-1], "m": 3 * t[:-1]}),
    ]
    log = import_log(mapping_of(Q, {**effort, "time": {"column": "t"}}), files)
    np.testing.assert_array_equal(log.joint_states.effort[:, 0], 3 * t[:-1])
    assert log.warnings == ()


def test_nothing_is_known_in_a_long_hole_of_a_signal_of_another_file(mapping_of, write_csv, tmp_path: Path) -> None:
    time = np.arange(400) * 0.01
    kept = (time < 1.0) | (time > 2.0)
    one = write_csv(tmp_path / "a.csv", {"t": time, "q": np.sin(time)})
    two = write_csv(tmp_path / "b.csv", {"t": time[kept] + 0.003, "u": np.cos(time[kept])})
    files = {"q": "a.csv", "u": "b.csv"}
    entry = {"column": "u", "quantity": "measured_torque", "unit": "Nm", "file": files["u"]}
    log = import_log(mapping_of({**Q, "file": files["q"]}, entry), [one, two])
    at, torque = (log.joint_states.stamp - log.joint_states.stamp[0]) * 1e-9, log.joint_states.effort[:, 0]
    lost = np.isnan(torque)
    assert at[lost].min() == pytest.approx(1.0, abs=0.03)
    assert at[lost].max() == pytest.approx(2.0, abs=0.03)
    assert lost.sum() == pytest.approx(100, abs=3)
