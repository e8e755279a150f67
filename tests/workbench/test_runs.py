"""Runs and their analysis in one call each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexros
from flexros.errors import InputError

SHORT = {"duration": 0.02}


def test_run_in_memory_equals_the_recorded_one(tmp_path: Path) -> None:
    kept = flexros.run("circle_dae", settings=SHORT, seed=3)
    recorded = flexros.run("circle_dae", settings=SHORT, seed=3, out=tmp_path / "log")
    assert kept.folder is None
    assert recorded.folder == tmp_path / "log"
    assert kept.log.joint_states.position is not None
    assert recorded.log.joint_states.position is not None
    assert np.array_equal(kept.log.joint_states.position, recorded.log.joint_states.position)


def test_effects_and_model_reach_the_plant() -> None:
    run = flexros.run(
        "diagnosis", model="two_mass", effects=["delay@all:time=0.001"], settings={"diagnosis.length": 10}
    )
    assert run.scenario.robot == "two_mass"
    assert run.scenario.plant.effects == ("delay@all:time=0.001",)
    assert "delay@all" in run._repr_html_()


def test_analysis_is_shown_plotted_and_converted() -> None:
    analysis = flexros.run("circle_dae", settings=SHORT).analysis
    value = analysis.to_pandas().loc[("Path", "path error, max"), "value"]
    assert analysis.path is not None
    assert value == pytest.approx(1e3 * analysis.path.path.maximum)
    assert "Path error, max" in analysis._repr_html_()
    assert "error drawn ×" in analysis.plot().layout.xaxis.title.text
    assert len(analysis.plot("errors").data) == 2
    with pytest.raises(InputError, match="path, errors"):
        analysis.plot("responses")


def test_analysis_of_a_path_finds_the_robot() -> None:
    analysis = flexros.analyze(Path(__file__).parents[2] / "bags" / "sample_circle_dae", label="sample")
    assert analysis.label == "sample"
    assert analysis.motors[0].joint == "motor_1"


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"transport": "topics"}, "direct, ros"),
        ({"transport": "ros"}, "folder"),
        ({"effects": "delay@all:time=0.001"}, "list"),
        ({"model": object()}, "name or the path"),
        ({"settings": {"durations": 1}}, "durations"),
    ],
)
def test_bad_input_is_refused(given: dict[str, object], text: str) -> None:
    with pytest.raises(InputError, match=text):
        flexros.run("circle_dae", **given)  # type: ignore[arg-type]
