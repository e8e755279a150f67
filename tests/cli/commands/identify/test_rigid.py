"""Rigid regression from the command line."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from flexros.cli.commands.identify.rigid import _print_excitation, _print_robot_file
from flexros.logs.stamps import stamps_ns
from flexros.logs.time_series import JointSeries, Log
from flexros.logs.write_log import write_log
from flexros.robot import load_robot
from flexros.robot.robot import LIBRARY

pytestmark = pytest.mark.slow

N, T = 6000, 1e-3
REALDATA = os.environ.get("FLEXROS_REALDATA", "")


def write_drive_log(folder: Path, seed: int, viscous: float = 210.0) -> str:
    """Log of a drive with M = 100 kg, Fv = 210 N s/m, Fc = 15 N that moves along slow sines."""
    rng = np.random.default_rng(seed)
    time = np.arange(N)[:, None] * T
    w = 2 * np.pi * np.array([0.3, 0.7, 1.1])
    phase = rng.uniform(0, 2 * np.pi, 3)
    q = 0.05 * np.sin(w * time + phase).sum(axis=1, keepdims=True)
    v = 0.05 * (w * np.cos(w * time + phase)).sum(axis=1, keepdims=True)
    a = -0.05 * (w**2 * np.sin(w * time + phase)).sum(axis=1, keepdims=True)
    effort = 100 * a + viscous * v + 15 * np.sign(v)
    stamp = stamps_ns(N, T)
    states = JointSeries(stamp, ("motor_1",), position=q + 1e-7 * rng.normal(size=q.shape))
    write_log(Log(states, JointSeries(stamp, ("motor_1",), effort=effort), provenance={"seed": seed}), folder)
    return str(folder)


@pytest.fixture
def logs(tmp_path: Path) -> list[str]:
    return [write_drive_log(tmp_path / name, seed) for seed, name in enumerate(("one", "two"))]


def test_results_are_printed_and_written(flexros, logs: list[str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    ended = flexros("identify", "rigid", *logs, "--model", "emps", "--out", str(out), "--cutoff", "50", "--json")
    assert ended.code == 0, ended.err
    printed = json.loads(ended.out)
    values = {row["name"]: row["value"] for row in printed["parameters"]}
    assert values["body_1.mass"] == pytest.approx(100, rel=5e-3)
    assert values["motor_1.coulomb_friction"] == pytest.approx(15, rel=0.02)
    assert printed["force_error_percent"]["cross_tests"][0]["total"] < 3
    assert printed["excitation"]["rich_enough"]
    assert json.loads((out / "rigid.json").read_text()) == printed
    assert load_robot(out / "identified.yaml").parameters["body_1.mass"].value == values["body_1.mass"]


def test_what_the_robot_file_cannot_have_is_said(flexros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    model, out = tmp_path / "smooth.yaml", tmp_path / "out"
    model.write_text((LIBRARY / "emps.yaml").read_text().replace("203.5034", "1.0"))
    log = write_drive_log(tmp_path / "driven", 1, viscous=-5.0)
    ended = flexros("identify", "rigid", log, "--model", str(model), "--out", str(out), "--cutoff", "50")
    assert ended.code == 0, ended.err
    assert ended.out.startswith("Verdict: the rigid model leaves 0.0")
    assert "left at nominal in the robot file: motor_1.viscous_friction" in ended.out
    assert "not met by the robot file: motor_1.viscous_friction, which is 1 there" in ended.out
    written = load_robot(out / "identified.yaml").parameters
    assert written["motor_1.viscous_friction"].value == 1.0
    assert written["body_1.mass"].value == pytest.approx(100, rel=5e-3)
    assert written["body_1.mass"].tolerance < 0.01


def test_no_robot_file_where_no_possible_robot_comes_near(flexros, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "identified.yaml").write_text("of a run before")
    log = write_drive_log(tmp_path / "driven", 1, viscous=-50.0)
    ended = flexros("identify", "rigid", log, "--model", "emps", "--out", str(out), "--cutoff", "50")
    assert ended.code == 2
    assert "no robot file was written: the rigid model leaves 0.0" in ended.err
    assert "but with infeasible values (the nearest feasible robot misses 1 of 4 and leaves" in ended.err
    assert len(ended.told) == 1
    assert [file.name for file in out.iterdir()] == ["rigid.json"]
    assert not json.loads((out / "rigid.json").read_text())["verdict"]["usable"]


def test_friction_that_has_no_place_in_the_robot_file_is_offered_as_an_effect(
    flexros, logs: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    arguments = ["identify", "rigid", logs[0], "--model", "emps", "--out", str(tmp_path / "out"), "--cutoff", "50"]
    ended = flexros(*arguments)
    assert "not in the robot file: motor_1.coulomb_friction 15" in ended.out
    assert "; add to a run: --effect coulomb_friction@motor_1:level=15" in ended.out
    ended = flexros(*arguments, "--asymmetric")
    assert "motor_1.viscous_friction in the robot file is the mean of 2" in ended.out


def test_long_lists_are_cut(capsys: pytest.CaptureFixture[str]) -> None:
    record = {
        "not_in_robot_file": {"values": {}, "effects": []},
        "means_in_robot_file": [],
        "left_at_nominal": {},
        "not_met": {f"body_{k}.mass": float(k) for k in range(40)},
    }
    _print_robot_file(record)
    lines = capsys.readouterr().out.splitlines()
    assert "body_2.mass, which is 2 there" in "".join(lines)
    assert "body_3.mass" not in "".join(lines)
    assert lines[-1] == "... 40 such lines in all, see rigid.json"


@pytest.mark.parametrize(
    ("missing", "condition", "sentence"),
    [
        (0, 5.0, "rich enough: condition number 5 (up to 100), all 11 base parameters excited"),
        (
            1,
            4.658,
            "NOT rich enough: 1 of 11 base parameters are not excited; the others are well conditioned, condition "
            "number 4.658 (up to 100)",
        ),
        (0, 230.0, "NOT rich enough: condition number 230 is above 100"),
        (2, 230.0, "NOT rich enough: 2 of 11 base parameters are not excited and condition number 230 is above 100"),
    ],
)
def test_reason_of_the_verdict_on_the_motion_is_said(
    capsys: pytest.CaptureFixture[str], missing: int, condition: float, sentence: str
) -> None:
    verdict = {
        "rich_enough": missing == 0 and condition <= 100,
        "condition_number": condition,
        "largest_condition_number": 100.0,
        "not_excited": [{"name": "body_1.mass", "reason": "nothing in the motion depends on it"}] * missing,
    }
    _print_excitation(verdict, 11)
    assert " ".join(capsys.readouterr().out.split()).startswith(f"Excitation {sentence}")


def test_table_for_people(flexros, logs: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "70")
    ended = flexros("identify", "rigid", *logs, "--model", "emps", "--out", str(tmp_path / "out"), "--asymmetric")
    assert ended.code == 0, ended.err
    assert "motor_1.coulomb_friction_backward" in ended.out
    assert max(len(line) for line in ended.out.splitlines() if line.startswith("│")) <= 70
    assert "body_1.mass = mass of body_1 + inertia of motor_1 at the arm" in ended.out
    assert "% in two (cross-test)" in ended.out
    assert "Excitation rich enough" in ended.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--model", "e12"], "has 1 joints (motor_1), but robot e12 has 2 motors (motor_1, motor_2)"),
        (["--model", "emps", "--cutoff", "-3"], "--cutoff is -3 Hz, but must be positive"),
        (["--model", "emps", "--cutoff", "400"], "but must be above 0 and at most a quarter of the sampling rate"),
    ],
)
def test_bad_input_is_one_sentence_and_code_2(flexros, logs, tmp_path: Path, arguments, message: str) -> None:
    ended = flexros("identify", "rigid", logs[0], "--out", str(tmp_path / "out"), *arguments)
    assert ended.code == 2
    assert message in ended.err
    assert len(ended.told) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(
    not REALDATA or not (Path(REALDATA) / "emps").is_dir(),
    reason="FLEXROS_REALDATA is unset or names no folder with emps/, the measured drive",
)
def test_csv_of_a_measured_drive_gives_the_published_values(flexros, tmp_path: Path) -> None:
    """Janot, Gautier and Brunot (2019), through import by the built-in mapping and the regression."""
    logs = []
    for name in ("DATA_EMPS", "DATA_EMPS_PULSES"):
        content = loadmat(Path(REALDATA) / "emps" / f"{name}.mat", squeeze_me=True)
        columns = np.column_stack([content[key] for key in ("t", "qg", "qm", "vir")])
        np.savetxt(tmp_path / f"{name}.csv", columns, fmt="%.17g", delimiter=",", header="t,qg,qm,vir", comments="")
        logs.append(str(tmp_path / name))
        assert flexros("import", "emps", str(tmp_path / f"{name}.csv"), "--out", logs[-1]).code == 0
    ended = flexros("identify", "rigid", *logs, "--model", "emps", "--out", str(tmp_path / "out"), "--json")
    assert ended.code == 0, ended.err
    printed = json.loads(ended.out)
    values = {row["name"]: row["value"] for row in printed["parameters"]}
    assert values["body_1.mass"] == pytest.approx(95.1089, rel=0.02)
    assert values["motor_1.viscous_friction"] == pytest.approx(203.5034, rel=0.02)
    assert values["motor_1.coulomb_friction"] == pytest.approx(20.3935, rel=0.02)
    errors = printed["force_error_percent"]
    assert errors["fit"]["total"] == pytest.approx(4.0834, abs=0.2)
    assert errors["cross_tests"][0]["total"] == pytest.approx(5.9824, abs=0.2)
