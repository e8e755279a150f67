"""An identified model makes the path error of the real robot smaller: E12 with springs 20 % off."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.scenario.scenario import Scenario, load_scenario
from flexros.validation.campaigns.path_improvement.comparison import Improvement, identify_and_compare

pytestmark = pytest.mark.slow

REAL = {"body_1.ry.stiffness": 0.8, "body_2.ry.stiffness": 1.2, "body_3.ry.stiffness": 0.8}


def experiment() -> Scenario:
    """A shorter form of the built-in experiment: two positions, one block."""
    built_in = load_scenario("identify_e12")
    assert built_in.identification is not None
    positions = built_in.identification.positions[1:]
    return built_in.with_values({"identification.positions": positions, "identification.periods": 1})


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Improvement, Path]:
    file = tmp_path_factory.mktemp("identified") / "identified.yaml"
    return identify_and_compare(experiment(), REAL, ("circle_dae2", "circle_fj"), file), file


def test_springs_are_found(found: tuple[Improvement, Path]) -> None:
    for name, factor in REAL.items():
        nominal, true, value, _ = found[0].parameters[name]
        assert true == pytest.approx(factor * nominal)
        assert value == pytest.approx(true, rel=0.01)


def test_identified_robot_is_a_robot_file(found: tuple[Improvement, Path]) -> None:
    improvement, file = found
    robot = load_robot(str(file))
    for name in REAL:
        assert robot.parameters[name].value == pytest.approx(improvement.parameters[name][2], rel=1e-6)


def test_path_error_is_smaller_with_dae_feedforward(found: tuple[Improvement, Path]) -> None:
    path = found[0].paths[0]
    assert path.method == "dae"
    assert path.nominal > 2e-3
    assert path.factor > 30
    assert path.identified >= 0.9 * path.true


def test_path_error_is_smaller_with_flexible_joint_feedforward(found: tuple[Improvement, Path]) -> None:
    path = found[0].paths[1]
    assert path.method == "flexible_joint"
    assert path.factor > 1.5
    assert path.identified == pytest.approx(path.true, rel=0.05)  # the rest is the method's own error


def test_unknown_parameter_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown parameter of the real robot 'body_9.ry.stiffness': did you mean"):
        identify_and_compare(experiment(), {"body_9.ry.stiffness": 0.8}, ("circle_fj",), tmp_path / "robot.yaml")


def test_motion_of_another_robot_is_refused(tmp_path: Path) -> None:
    short = experiment().with_values({"identification.positions": [[0, 0.3]], "identification.blocks": 2})
    with pytest.raises(InputError, match="scenario six_axis_moves moves robot six_axis, but e12 was identified"):
        identify_and_compare(short, REAL, ("six_axis_moves",), tmp_path / "robot.yaml")
