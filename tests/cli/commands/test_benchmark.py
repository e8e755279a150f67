"""The command of the feedback benchmark."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

Flexros = Callable[..., "object"]


def test_json_without_noise_has_the_cost_of_the_check(flexros: Flexros) -> None:
    ended = flexros("benchmark", "pid_check", "--noise", "0", "--json")
    assert ended.code == 0
    content = json.loads(ended.out)
    assert content["V"] == pytest.approx(138.903095, abs=1e-6)
    assert all(demand["passed"] for demand in content["demands"])


def test_two_controllers_side_by_side_with_report_and_file(flexros: Flexros, tmp_path: Path) -> None:
    (tmp_path / "soft.yaml").write_text("{kind: pid, kp: 10, ki: 20, kd: 1}")
    report, out = tmp_path / "r.html", tmp_path / "r.json"
    given = ("--seeds", "2", "--report", str(report), "--out", str(out))
    ended = flexros("benchmark", "pid_check", str(tmp_path / "soft.yaml"), *given)
    assert ended.code == 0
    assert "T_NOISE" in ended.out
    assert [row["controller"] for row in json.loads(out.read_text())] == ["pid_check", "soft"]
    assert "not reproduced" in report.read_text()


def test_without_a_controller_the_built_in_ones_are_listed(flexros: Flexros) -> None:
    assert "pid_check" in {row["name"] for row in json.loads(flexros("benchmark", "--json").out)}


@pytest.mark.parametrize(("option", "value"), [("--noise", "-1"), ("--seeds", "a"), ("--seeds", "1,1")])
def test_wrong_options_are_named(flexros: Flexros, option: str, value: str) -> None:
    ended = flexros("benchmark", "pid_check", option, value)
    assert ended.code == 2
    assert option in ended.err


def test_on_a_robot_of_several_axes(flexros: Flexros, tmp_path: Path) -> None:
    assert {"pid", "cascade"} <= {row["name"] for row in json.loads(flexros("benchmark", "--on", "e12", "--json").out)}
    page, out = tmp_path / "motion.html", tmp_path / "motion.json"
    given = ("--seeds", "1", "--report", str(page), "--out", str(out))
    ended = flexros("benchmark", "pid", "state_feedback", "--on", "e12", *given)
    assert ended.code == 0
    assert "settling, M1" in ended.out
    for row in json.loads(out.read_text()):
        assert set(row["sets"]["M1"]) == {"e", "Ts", "T_NOISE", "T_MAX", "V"}
    for words in ("Multivariable benchmark on e12", "settling, M1", "Loops of state_feedback", "Smallest margins"):
        assert words in page.read_text()
    assert flexros("benchmark", "pid", "--on", "elbow").code == 2
    assert flexros("benchmark", "pid", "--on", "e12", "--noise", "1e-5").code == 2


def test_a_log_has_its_files_too(flexros: Flexros, tmp_path: Path) -> None:
    log, report, out = tmp_path / "log", tmp_path / "r.html", tmp_path / "r.json"
    assert flexros("run", "feedback_benchmark", "--transport", "direct", "--out", str(log)).code == 0
    ended = flexros("benchmark", str(log), "--report", str(report), "--out", str(out), "--json")
    assert ended.code == 0
    assert json.loads(out.read_text()) == json.loads(ended.out)
    cost = json.loads(ended.out)["sets"]["nominal"]["V"]
    assert f"{cost:.5g}" in report.read_text()


def test_many_controllers_are_ranked_in_lines(flexros: Flexros) -> None:
    names = ("qft", "pid_check", "mixed_sensitivity", "pid_optimised", "lqg")
    ended = flexros("benchmark", *names, "--noise", "0")
    places = [ended.out.index(f" {name} ") for name in ("lqg", "pid_check", "pid_optimised", "qft")]
    assert places == sorted(places)
    assert "138.90" in ended.out
    assert len(ended.out.splitlines()) < 20
