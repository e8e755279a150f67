"""Identification of one axis from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.logs.write_log import write_log
from tests.identify.axis.recorded_axis import TRUTH, recorded_axis

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", name="logs")
def fixture_logs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Logs of two_mass with a hardening gear and friction."""
    folder = tmp_path_factory.mktemp("axis")
    for name, seed in (("one", 1), ("two", 2)):
        write_log(recorded_axis(seed=seed, samples=2500), folder / name)
    return [str(folder / "one"), str(folder / "two")]


def test_axis_is_found_again_and_written(flexros, logs: list[str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    ended = flexros(
        "identify", "axis", logs[0], "--model", "two_mass", "--validation", logs[1], "--out", str(out), "--json"
    )
    assert ended.code == 0, ended.err
    record = json.loads(ended.out)
    assert json.loads((out / "axis.json").read_text()) == record
    values = {row["name"]: row["value"] for row in record["nonlinear"]["parameters"]}
    for name in ("motor_inertia", "arm_1_inertia", "gear_stiffness", "gear_stiffening", "gear_knee"):
        assert values[name] == pytest.approx(TRUTH[name], rel=0.03)
    assert record["frequencies_from"] == "linear model of two_mass"
    assert record["antiresonances_hz"] == [pytest.approx(15.9, abs=0.05)]
    assert record["gain_on"] == "validation"
    assert record["gain"] > 0.3
    assert record["nonlinear"]["validation"]["simulation_percent"] > 97
    assert [Path(entry["file"]).name for entry in record["provenance"]["logs"].values()] == ["one", "two"]


def test_table_for_people(flexros, logs: list[str], tmp_path: Path) -> None:
    ended = flexros(
        "identify", "axis", logs[0], "--model", "two_mass", "--out", str(tmp_path), "--gear", "linear",
        "--antiresonance", "15.5", "--resonance", "26", "--start", "gear_damping=20", "--bound", "gear_damping=5:100",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    assert "gear_stiffness" in ended.out
    assert "Started from antiresonances 15.5 Hz and resonances 26 Hz (command line)" in ended.out
    assert "Fit: linear gear: prediction 99.9" in ended.out
    assert "takes away" not in ended.out
    assert "warning: neighbouring prediction errors are correlated" in ended.out


def test_frequencies_come_from_the_response_of_an_identification_log(flexros, tmp_path: Path) -> None:
    log = tmp_path / "log"
    excitation = "{kind: multisine, period: 1.0, lowest: 1, highest: 45, amplitude: 6}"
    ended = flexros(
        "run", "identify_two_mass", "--transport", "direct", "--out", str(log), "--json",
        "--set", f"identification.excitation={excitation}", "--set", "identification.periods=2",
        "--set", "identification.blocks=2",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    ended = flexros(
        "identify", "axis", str(log), "--model", "two_mass", "--gear", "linear", "--out", str(tmp_path / "o"), "--json"
    )
    assert ended.code == 0, ended.err
    record = json.loads(ended.out)
    assert record["frequencies_from"] == "frequency response of the log"
    assert record["resonances_hz"] == [pytest.approx(25.2, rel=0.03)]
    values = {row["name"]: row["value"] for row in record["linear"]["parameters"]}
    assert values["gear_stiffness"] == pytest.approx(6e4, rel=0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--model", "emps"], "robot emps has fewer antiresonances of motor_1 than the 1 of a model of 2 masses"),
        (["--joint", "motor_7"], "unknown joint 'motor_7' in --joint, robot two_mass"),
        (["--gear", "cubik"], "gear"),
        (["--masses", "4"], "masses"),
        (["--antiresonance", "15"], "give equally many"),
        (["--start", "gear_knee"], "--start is 'gear_knee', but must be key=value"),
        (["--start", "gear_knee=stiff"], "--start gear_knee is 'stiff', but must be a number"),
        (["--bound", "gear_knee=1"], "--bound is 'gear_knee=1', but must be NAME=LOW:HIGH"),
        (["--bound", "gear_nee=1:2"], "did you mean 'gear_knee'"),
        (["--output", "velocity", "--joint", "motor_1", "--masses", "3"], "robot two_mass has fewer antiresonances"),
    ],
)
def test_bad_input_is_one_sentence_and_code_2(
    flexros, logs: list[str], tmp_path: Path, arguments: list[str], message: str
) -> None:
    model = [] if "--model" in arguments else ["--model", "two_mass"]
    ended = flexros("identify", "axis", logs[0], *model, "--out", str(tmp_path / "out"), *arguments)
    assert ended.code == 2
    assert message in ended.err
    assert len(ended.told) == 1
    assert not (tmp_path / "out").exists()
