"""The command that designs controllers."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

Flexros = Callable[..., "object"]


def test_design_writes_a_controller_that_the_benchmark_takes(flexros: Flexros, tmp_path: Path) -> None:
    out, report = tmp_path / "lqg.yaml", tmp_path / "lqg.html"
    ended = flexros("design", "lqg", "--set", "walk=0.004", "--out", str(out), "--report", str(report), "--json")
    assert ended.code == 0
    margins = json.loads(ended.out)["controllers"]["controller"]["margins"]
    assert len(margins) == 5
    assert all(entry["stable"] for entry in margins)
    assert "Nyquist" in report.read_text()
    assert "flexros design lqg --model four_mass --set walk=0.004" in out.read_text()
    checked = flexros("benchmark", str(out), "--noise", "0", "--json")
    assert json.loads(checked.out)["V"] < 200.0


@pytest.mark.parametrize("controller", ["elbow_torque_feedback", "elbow_computed_torque", "acceleration_1"])
def test_margins_of_controllers_with_further_sensors_or_a_model(
    flexros: Flexros, controller: str, tmp_path: Path
) -> None:
    page = tmp_path / "loops.html"
    ended = flexros("design", "margins", "--controller", controller, "--json", "--report", str(page))
    assert ended.code == 0, ended.err
    for of_law in json.loads(ended.out)["controllers"].values():
        assert all(entry["stable"] and 1.0 < entry["sensitivity"] < 6.0 for entry in of_law["margins"])
    assert all(words in page.read_text() for words in ("Bode", "Nyquist", "unit step"))


def test_margins_of_the_controller_of_a_scenario(flexros: Flexros) -> None:
    ended = flexros("design", "margins", "--controller", "circle_pd", "--json")
    assert ended.code == 0
    margins = json.loads(ended.out)["controllers"]["controller"]["margins"]
    assert [entry["motor"] for entry in margins] == ["motor_1", "motor_2"]


def test_structure_is_tuned_and_can_be_tuned_further(flexros: Flexros, tmp_path: Path) -> None:
    pytest.importorskip("cma")
    first, second = tmp_path / "first.yaml", tmp_path / "second.yaml"
    assert flexros("design", "structure", "--tune", "6", "--out", str(first), "--json").code == 0
    given = ("--set", "lead_lags=1", "--tune", "6", "--start", str(first), "--out", str(second))
    assert flexros("design", "structure", *given, "--json").code == 0
    assert "order 3" in second.read_text()


def test_without_a_method_all_are_listed(flexros: Flexros) -> None:
    listed = json.loads(flexros("design", "--json").out)
    assert {"lqg", "pole_placement", "loop_shaping", "mixed_sensitivity", "structure", "margins"} <= set(listed)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("lqq",), "lqg"),
        (("lqg", "--set", "walk"), "--set"),
        (("lqg", "--set", "wlak=1"), "walk"),
        (("structure",), "--tune"),
        (("lqg", "--model", "e12", "--tune", "5"), "--model"),
        (("loop_shaping", "--model", "e12"), "one motor"),
        (("margins",), "--controller"),
        (("margins", "--controller", "circle_pd", "--out", "found.yaml"), "--out"),
    ],
)
def test_wrong_arguments_are_named(flexros: Flexros, arguments: tuple[str, ...], named: str) -> None:
    ended = flexros("design", *arguments)
    assert ended.code == 2
    assert named in ended.err
