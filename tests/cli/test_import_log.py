"""Import of foreign logs from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.logs.reader import read_log

MAPPING = """
time: {rate: 1000}
columns:
  - {column: q, quantity: position, unit: deg}
  - {column: u, quantity: torque_command, unit: Nm}
"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str]:
    (tmp_path / "mine.yaml").write_text(MAPPING)
    (tmp_path / "log.csv").write_text("q,u\n" + "".join(f"{k},{2 * k}\n" for k in range(100)))
    return str(tmp_path / "mine.yaml"), str(tmp_path / "log.csv")


def test_import_writes_a_log(flexros, files, tmp_path: Path) -> None:
    ended = flexros("import", *files, "--out", str(tmp_path / "bag"), "--json")
    assert ended.code == 0, ended.err
    printed = json.loads(ended.out)
    assert [row["topic"] for row in printed["topics"]] == ["joint_states", "joint_commands"]
    assert printed["topics"][0]["rate_hz"] == pytest.approx(1000)
    assert read_log(tmp_path / "bag").joint_commands.effort[-1, 0] == 198


def test_table_says_what_was_imported(flexros, files, tmp_path: Path) -> None:
    ended = flexros("import", *files, "--out", str(tmp_path / "bag"))
    assert ended.code == 0, ended.err
    assert "joint_commands" in ended.out
    assert "Joints: motor_1" in ended.out


def test_analyse_takes_the_log(flexros, files, tmp_path: Path) -> None:
    flexros("import", *files, "--out", str(tmp_path / "bag"))
    assert flexros("analyze", str(tmp_path / "bag"), "--json").code == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("emp", None), "unknown mapping 'emp': did you mean 'emps'? allowed are emps"),
        (("emps", None), "unknown column of mapping emps 'qm'"),
        ((None, "nowhere.csv"), "there is no file nowhere.csv"),
    ],
)
def test_bad_input_is_one_sentence_and_code_2(flexros, files, tmp_path: Path, change, message: str) -> None:
    arguments = [given or usual for given, usual in zip(change, files, strict=True)]
    ended = flexros("import", *arguments, "--out", str(tmp_path / "bag"))
    assert ended.code == 2
    assert message in ended.err
    assert ended.err.count("\n") == 1
    assert not (tmp_path / "bag").exists()


def test_existing_folder_is_kept(flexros, files, tmp_path: Path) -> None:
    assert flexros("import", *files, "--out", str(tmp_path / "bag")).code == 0
    ended = flexros("import", *files, "--out", str(tmp_path / "bag"))
    assert ended.code == 2
    assert "exists" in ended.err
