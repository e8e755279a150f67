"""The whole identification procedure as a function, without the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.errors import InputError, InterruptedRunError, RunError
from flexros.identify.design.experiment_design import DesignSettings
from flexros.identify.graybox.search import SearchSettings
from flexros.robot import load_robot
from flexros.scenario.identification import DesignedExperiment, template_scenario, with_real_robot
from flexros.scenario.identification_procedure import DESIGN, ESTIMATE, FIT, Identification, identify_robot
from flexros.scenario.scenario import Scenario
from flexros.scenario.transports import RunResult, run_direct

E12 = load_robot("e12")
UNKNOWN = ("body_1.ry.stiffness", "body_3.ry.damping")


def _identified(folder: Path, run: Callable[[DesignedExperiment, Path], RunResult], **given: object) -> Identification:
    """Identify E12 whose first spring is 30 % stiffer, in one position."""
    real = E12.with_values({"body_1.ry.stiffness": 1.3e5})
    template = with_real_robot(template_scenario(E12, "e12"), E12, real)
    template = template.with_values({"identification.transient_periods": 2}, "test")
    wanted = {
        "unknown": UNKNOWN,
        "design": DesignSettings(positions=1, candidates=20),
        "longest": 0.0,
        "settings": SearchSettings(starts=2),
        **given,
    }
    return identify_robot(E12, template, folder, run, **wanted)


def _directly(experiment: DesignedExperiment, log: Path) -> RunResult:
    return run_direct(experiment.scenario, log)


def _ended(code: int) -> Callable[[DesignedExperiment, Path], RunResult]:
    """Give a run that ends before its log has a sample."""
    return lambda _, log: RunResult(code, "the plant left its limits at 1.5 s", "direct", log, 0, 0.0, 0.0)


@pytest.mark.slow
def test_procedure_finds_the_values_of_the_real_robot_and_writes_its_files(tmp_path: Path) -> None:
    reported: list[tuple[str, int, int]] = []
    found = _identified(tmp_path / "e12", _directly, progress=lambda *what: reported.append(what))
    content = found.as_dict()
    stiffness, damping = content["parameters"]
    assert (stiffness["name"], damping["name"]) == UNKNOWN
    assert stiffness["truth"] == pytest.approx(1.3e5)
    assert stiffness["value"] == pytest.approx(1.3e5, rel=0.01)
    assert content["run"]["transport"] == content["experiment"]["transport"] == "direct"
    assert content["experiment"]["robot_time"] == pytest.approx(found.experiment.duration)
    assert {path.name for path in (tmp_path / "e12").iterdir()} == {
        "experiment.yaml", "log", "frf.nc", "identified.yaml", "identification.json", "report.html",
    }  # fmt: skip
    assert list(dict.fromkeys(step for step, _, _ in reported)) == [DESIGN, ESTIMATE, FIT]
    assert reported[-1] == (FIT, 2, 2)


@pytest.mark.parametrize(("code", "error"), [(3, RunError), (130, InterruptedRunError)])
def test_an_aborted_run_ends_the_procedure(tmp_path: Path, code: int, error: type[RunError]) -> None:
    with pytest.raises(error, match=r"the plant left its limits at 1\.5 s") as caught:
        _identified(tmp_path, _ended(code))
    assert caught.value.exit_code == code
    assert [path.name for path in tmp_path.iterdir()] == ["experiment.yaml"]


def test_a_folder_with_a_log_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log").mkdir()
    with pytest.raises(InputError, match="log exists already") as caught:
        _identified(tmp_path, _directly)
    assert caught.value.argument == "out"


@pytest.mark.parametrize(
    ("given", "argument", "message"),
    [
        ({"unknown": ("body_1.ry.stifness",)}, "unknown", "did you mean 'body_1.ry.stiffness'"),
        ({"settings": SearchSettings("FOO")}, "estimator", "unknown estimator 'FOO'"),
        ({"settings": SearchSettings(weights="foo")}, "weights", "unknown kind of weights 'foo'"),
        ({"settings": SearchSettings(starts=0)}, "starts", "0 starts"),
        ({"settings": SearchSettings(seed=-1)}, "seed", "-1"),
        ({"settings": SearchSettings(bounds={"motor_1.inertia": (1.0, 2.0)})}, "bound", "'motor_1.inertia'"),
    ],
)
def test_settings_are_checked_before_anything_is_made(
    tmp_path: Path, given: dict[str, object], argument: str, message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        _identified(tmp_path / "new", _directly, **given)
    assert caught.value.argument == argument
    assert not (tmp_path / "new").exists()


def test_values_of_the_template_take_precedence_over_the_real_robot() -> None:
    real = E12.with_values({"body_1.ry.stiffness": 1.3e5, "motor_2.inertia": 90.0})
    template: Scenario = template_scenario(E12, "e12").with_values({"plant.values": {"motor_2.inertia": 95}}, "test")
    scenario = with_real_robot(template, E12, real)
    assert scenario.plant.values == {"body_1.ry.stiffness": 1.3e5, "motor_2.inertia": 95.0}
