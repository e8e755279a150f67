"""The page of measured robots and the programs that write it; the logs are not in this repository."""

from __future__ import annotations

import hashlib
import importlib
import io
import json
import os
import pickle
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

PROGRAMS = Path(__file__).parents[2] / "docs" / "results" / "programs"
REALDATA = os.environ.get("FLEXROS_REALDATA", "")
DATA = Path(REALDATA) / "dfki_double_pendulum"


@pytest.fixture(scope="module", autouse=True)
def found_programs() -> Iterator[None]:
    folders = [str(PROGRAMS), str(PROGRAMS / "measured")]
    sys.path[:0] = folders
    yield
    for folder in folders:
        sys.path.remove(folder)


def program(name: str) -> ModuleType:
    return importlib.import_module(name)


def case_of(name: str) -> Any:
    return next(case for case in program("real_robots_cases").CASES if case.name == name)


def value(number: float, std: float, unit: str = "Nm", at_limit: bool = False) -> dict[str, Any]:
    return {"value": number, "std": std, "unit": unit, "at_limit": at_limit}


def coulomb(motor: int, level: dict[str, Any]) -> dict[str, Any]:
    return {
        "effect": "coulomb_friction",
        "location": f"motor_{motor}",
        "probability": 0.99,
        "parameters": {"level": level},
        "closed_fraction": 0.6,
    }


def gap(closed: float | None) -> dict[str, Any]:
    return {"before": 100.0, "after": 5.0, "closed_fraction": closed, "interval": [0.7, 0.95] if closed else None}


@pytest.fixture
def pendulum() -> dict[str, Any]:
    """A small JSON file of a case, with two logs."""
    return {
        "case": "dfki_double_pendulum",
        "diagnosis": {
            "verdict": "partly_explained",
            "causes": [coulomb(1, value(0.17, 0.01)), coulomb(2, value(0.4, 0.02))],
            "model_numbers": [],
            "gap": gap(0.9),
            "budget": [],
            "unexplained": [{"joint": "motor_1", "regime": "reversal", "share": 0.07}],
            "warnings": ["weak effects remain undetected"],
            "seconds": 41.0,
            "cpu_seconds": 60.0,
            "cores": 2,
            "largest_memory_gb": 0.4,
        },
        "least_squares": {"refused": "", "torque_error_percent": 9.0, "friction": {}, "effects": []},
        "mujoco": {"skipped": "it is not installed"},
        "logs": {
            "C_143339": {"diagnosis": gap(0.5), "hand": gap(0.9)},
            "C_143524": {"diagnosis": gap(-0.25), "hand": gap(None)},
        },
    }


def test_page_states_what_is_known_and_what_was_found(pendulum: dict[str, Any]) -> None:
    text = program("real_robots_page").page({"dfki_double_pendulum": pendulum})
    assert "| `partly_explained` | 2 of 2 | 1 of 2 | -25 to 50 % | 90 % | - | - | 41 | 0.40 |" in text
    assert "| Coulomb friction | motor_1 | 0.16 to 0.313 Nm | 0.17 ± 0.01 Nm | yes |" in text
    assert "| Coulomb friction | motor_2 | 0.11 to 0.185 Nm | 0.4 ± 0.02 Nm | no |" in text
    assert "| C_143339 | 100 | 50.0 % (70 to 95) | 90.0 % (70 to 95) |" in text
    assert "motor_1 reversal 7 %" in text
    assert "> weak effects remain undetected" in text
    assert "MuJoCo: not applied, since it is not installed." in text


def test_page_lists_cases_that_were_not_run(pendulum: dict[str, Any]) -> None:
    interrupted = {"case": "emps", "versions": {}}
    text = program("real_robots_page").page({"dfki_double_pendulum": pendulum, "emps": interrupted})
    (line,) = (line for line in text.splitlines() if line.startswith("Not run:"))
    assert "Six axes of a UR10e" in line
    assert "EMPS" in line
    assert "Double pendulum" not in line


def test_diagnosis_that_did_not_end_has_no_shares(pendulum: dict[str, Any]) -> None:
    pendulum |= {"diagnosis": {"verdict": "not finished", "seconds": 3600.0}}
    pendulum["logs"] = {"C_143339": {"hand": gap(0.9)}}
    text = program("real_robots_page").page({"dfki_double_pendulum": pendulum})
    assert "| `not finished` | 0 of 2 | 0 of 2 | - | 90 % | - | - | 3600 | - |" in text


def test_sizes_are_counted_whose_interval_has_the_stated_range(pendulum: dict[str, Any]) -> None:
    """Stated are 0.16 to 0.313 Nm at motor 1 and 0.11 to 0.185 Nm at motor 2."""
    pendulum["diagnosis"]["causes"] = [coulomb(1, value(0.3, 0.001)), coulomb(2, value(0.2, 0.008))]
    text = program("real_robots_page").page({"dfki_double_pendulum": pendulum})
    assert "Of the 2 sizes of what is named, 2 are within 1.96 of their standard deviations" in text
    pendulum["diagnosis"]["causes"][1] = coulomb(2, value(0.2, 0.007))
    assert "named, 1 are within" in program("real_robots_page").page({"dfki_double_pendulum": pendulum})


def test_value_at_its_limit_is_not_found(pendulum: dict[str, Any]) -> None:
    pendulum["diagnosis"]["causes"] = [coulomb(1, value(0.17, 0.01, at_limit=True))]
    rows = program("real_robots_page").agreement(case_of("dfki_double_pendulum"), pendulum["diagnosis"])
    assert [found for _, found, _, _ in rows] == [None, None]


def test_value_that_is_not_determined_is_not_found(pendulum: dict[str, Any]) -> None:
    pendulum["diagnosis"]["causes"] = [coulomb(1, {**value(0.17, 0.2), "determined": False})]
    rows = program("real_robots_page").agreement(case_of("dfki_double_pendulum"), pendulum["diagnosis"])
    assert [found for _, found, _, _ in rows] == [None, None]


def test_names_that_hang_on_tolerances_have_a_line(pendulum: dict[str, Any]) -> None:
    row = {"effect": "torque_bias", "location": "motor_1", "halved": 1.0, "stated": 0.97, "doubled": 0.02}
    pendulum["diagnosis"]["tolerance_sensitivity"] = [{**row, "changes": True}]
    text = program("real_robots_page").page({"dfki_double_pendulum": pendulum})
    assert "`torque_bias@motor_1` (halved 100 %, stated 97 %, doubled 2 %)" in text
    pendulum["diagnosis"]["tolerance_sensitivity"] = [{**row, "changes": False}]
    assert "No name changes" in program("real_robots_page").page({"dfki_double_pendulum": pendulum})


def test_effect_counts_from_the_robot_file_and_a_number_of_the_model_from_zero() -> None:
    inertia = {"name": "motor_1.inertia", "nominal": 0.0635, "value": 0.5, "std": 0.02, "unit": "kg m2"}
    rows = program("real_robots_page").agreement(case_of("quanser_stage_1"), {"causes": [], "model_numbers": [inertia]})
    assert [(found, near) for _, found, _, near in rows] == [(None, False), (0.5, True)]
    viscous = {
        "effect": "viscous_friction",
        "location": "motor_1",
        "probability": 0.9,
        "parameters": {"coefficient": value(-1.3, 0.1)},
    }
    stage_2, agreement = case_of("quanser_stage_2"), program("real_robots_page").agreement
    assert agreement(stage_2, {"causes": [viscous]})[1][1] == pytest.approx(0.2)
    assert agreement(stage_2, {"causes": [viscous | {"probability": 0.1}]})[1][1] is None


def test_page_in_the_repository_is_that_of_its_json_files() -> None:
    cases = program("real_robots_cases").CASES
    files = {case.name: PROGRAMS.parent / "data" / "real_robots" / f"{case.name}.json" for case in cases}
    found = {name: json.loads(file.read_text(encoding="utf-8")) for name, file in files.items() if file.is_file()}
    written = (PROGRAMS.parent / "real_robots.md").read_text(encoding="utf-8")
    assert written == program("real_robots_page").page(found)


def test_files_of_ours_load() -> None:
    from flexros.logs.foreign.mapping import load_mapping
    from flexros.robot import load_robot

    own = program("real_robots_case").OWN
    for robot in own.glob("*_robot.yaml"):
        columns = load_mapping(str(own / robot.name.replace("_robot", ""))).columns
        assert {column.joint for column in columns} >= set(load_robot(robot).joint_names)
    wrist = [column for column in load_mapping(str(own / "ur10e.yaml")).columns if column.joint == "motor_5"]
    assert {column.quantity: column.sign for column in wrist} == dict.fromkeys(
        ("position", "velocity", "measured_torque"), -1
    )


def saved_tensor(storage_class: str) -> bytes:
    """A dictionary with the tensor [[0, 1, 2], [3, 4, 5]], as PyTorch saves it."""
    index = (
        b"\x80\x02}X\x03\x00\x00\x00dofctorch._utils\n_rebuild_tensor_v2\n((X\x07\x00\x00\x00storagec"
        + storage_class.encode()
        + b"\nX\x01\x00\x00\x000X\x03\x00\x00\x00cpuK\x06tQK\x00K\x02K\x03\x86K\x03K\x01\x86\x89Nt"
        + b"Rs."
    )
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr("log/data.pkl", index)
        archive.writestr("log/data/0", np.arange(6, dtype="<f4").tobytes())
    return content.getvalue()


def test_tensors_are_read_without_pytorch() -> None:
    found = program("quadruped_legs").tensors(saved_tensor("torch\nFloatStorage"))
    np.testing.assert_array_equal(found["dof"], [[0, 1, 2], [3, 4, 5]])


def test_a_file_that_holds_more_than_tensors_is_refused() -> None:
    with pytest.raises(pickle.UnpicklingError, match="posix.system is no part of a tensor"):
        program("quadruped_legs").tensors(saved_tensor("posix\nsystem"))


def test_a_leg_becomes_an_arm_with_servos_on_a_fixed_body(tmp_path: Path) -> None:
    from flexros.robot import load_robot
    from flexros.robot.exchange.mjcf.robot_import import robot_from_mjcf

    def link(name: str, within: str = "") -> str:
        inertial = '<inertial pos="0 0 -0.1" mass="1" diaginertia="0.01 0.01 0.01"/>'
        return f'<body name="{name}">{inertial}<joint name="{name}_joint"/><geom size="0.1"/>{within}</body>'

    legs = "".join(link(f"{leg}_hip", link(f"{leg}_thigh", link(f"{leg}_calf"))) for leg in ("FL", "RL"))
    body = f'<body name="base"><freejoint/><geom size="0.1"/>{legs}</body>'
    motors = '<actuator><motor name="FL_hip" joint="FL_hip_joint"/></actuator>'
    text = f"<mujoco><option/><asset/><worldbody>{body}</worldbody>{motors}<sensor/><keyframe/></mujoco>"
    file = tmp_path / "leg.xml"
    file.write_text(program("quadruped_legs").leg_mjcf(text, "RL"), encoding="utf-8")
    (tmp_path / "leg.yaml").write_text(robot_from_mjcf(file).text, encoding="utf-8")
    robot = load_robot(tmp_path / "leg.yaml")
    assert [robot.parameters[f"{name}.servo_stiffness"].value for name in robot.joint_names] == [20.0] * 3
    assert robot.torque_limits.tolist() == [23.7, 23.7, 45.43]
    assert robot.sample_time == 0.005


def git(folder: Path, *words: str) -> str:
    who = ["-c", "user.name=n", "-c", "user.email=e"]
    done = subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout.strip()


def test_files_are_fetched_from_a_bare_clone_and_a_folder(tmp_path: Path) -> None:
    fetching = program("measured.fetch_real_robots")
    origin, bare = tmp_path / "origin", tmp_path / "bare"
    (origin / "data").mkdir(parents=True)
    (origin / "data" / "log.csv").write_bytes(b"1,2\n")
    git(origin, "init", "-q")
    git(origin, "add", ".")
    git(origin, "commit", "-qm", "data")
    git(tmp_path, "clone", "-q", "--bare", str(origin), str(bare))
    wanted = {"data/log.csv": hashlib.sha256(b"1,2\n").hexdigest()}
    repository = fetching.Repository("someone", "robot", git(origin, "rev-parse", "HEAD"), wanted)
    for index, source in enumerate((bare, origin)):
        target = tmp_path / f"fetched_{index}"
        assert fetching.fetch(target, [source], [repository]) == ()
        assert (target / "robot" / "data" / "log.csv").read_bytes() == b"1,2\n"
    other = replace(repository, files={"data/log.csv": "0" * 64})
    (reason,) = fetching.fetch(tmp_path / "other", [bare], [other])
    assert "checksum" in reason
    assert not (tmp_path / "other").exists()


def test_paths_with_spaces_are_written_as_addresses_have_them() -> None:
    repository = program("measured.fetch_real_robots").Repository("someone", "robot", "1a2b", {})
    assert repository.url("logs/10s FF.mat") == "https://raw.githubusercontent.com/someone/robot/1a2b/logs/10s%20FF.mat"


def test_files_that_cannot_be_had_are_skipped_with_the_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fetching = program("measured.fetch_real_robots")
    (reason,) = fetching.fetch(tmp_path / "fetched", [tmp_path], fetching.REPOSITORIES[1:])[:1]
    assert "Optimal_SysID" in reason

    def no_network(*_: object, **__: object) -> None:
        raise fetching.urllib.error.URLError("no network")

    monkeypatch.setattr(fetching.urllib.request, "urlopen", no_network)
    reasons = fetching.fetch(tmp_path / "fetched")
    assert len(reasons) == len(fetching.REPOSITORIES)
    assert all("no network" in reason for reason in reasons)


def test_case_without_data_is_skipped_with_the_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from flexros.errors import InputError

    monkeypatch.setenv("FLEXROS_REALDATA", str(tmp_path))
    with pytest.raises(InputError, match="FLEXROS_REALDATA has no emps"):
        program("real_robots").data_of(case_of("emps"), None)
    with pytest.raises(InputError, match="fetch_real_robots"):
        program("real_robots").data_of(case_of("ur10e"), None)


@pytest.mark.slow
@pytest.mark.skipif(
    not REALDATA or not DATA.is_dir(),
    reason="FLEXROS_REALDATA is unset or names no folder with dfki_double_pendulum/, the measured pendulum",
)
def test_case_is_run_step_by_step(tmp_path: Path) -> None:
    """The limit ends the diagnosis early; the other steps need none of it."""
    case = case_of("dfki_double_pendulum")
    case = replace(case, further={"C_143339": ("C_143339.csv",)}, by_mujoco="of its time")
    result = tmp_path / "results" / "case.json"
    program("real_robots_run").Run(case, DATA, tmp_path / "work", result, limit=0.5, patience=1.0).all_steps()
    found = json.loads(result.read_text(encoding="utf-8"))
    assert found["diagnosis"]["verdict"] == "not finished"
    assert found["least_squares"]["friction"]["motor_1.coulomb_friction"]["value"] == pytest.approx(0.2, rel=0.2)
    closed = {way: found["logs"]["C_143339"][way]["closed_fraction"] for way in ("hand", "least_squares")}
    assert closed["hand"] > 0.9
    found["least_squares"]["torque_error_percent"] = -1.0
    result.write_text(json.dumps(found), encoding="utf-8")
    program("real_robots_run").Run(case, DATA, tmp_path / "work", result, limit=0.5, patience=1.0).all_steps()
    assert json.loads(result.read_text(encoding="utf-8")) == found
    shutil.rmtree(tmp_path / "work" / "rigid")  # of another run: the friction alone would stand for its robot
    program("real_robots_run").Run(case, DATA, tmp_path / "work", result, limit=0.5, patience=1.0).all_steps()
    assert json.loads(result.read_text(encoding="utf-8"))["least_squares"]["torque_error_percent"] > 0
    assert (tmp_path / "work" / "rigid" / "identified.yaml").is_file()
