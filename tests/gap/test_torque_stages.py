"""Searches of one log with smaller and smaller tolerances of its torques."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from flexros.effects import RobotWithEffects
from flexros.gap import diagnose as diagnose_module
from flexros.gap import torque_stages
from flexros.gap.diagnose import diagnose
from flexros.gap.diagnosis_task import DiagnosisTask, SearchedLog
from flexros.gap.fit.candidate_fit import CandidateFit
from flexros.record.record import Record
from flexros.robot import Robot
from tests.gap.diagnosis_logs import ROBOT, record_of, settings_of
from tests.gap.rigid_arm import arm, record_of_arm

FEW = settings_of("coulomb_friction", "viscous_friction")
Searches = list[tuple[float, frozenset[str], frozenset[str]]]


@pytest.fixture(name="searches")
def searches_fixture(monkeypatch: pytest.MonkeyPatch) -> Searches:
    """Receives the tolerance of torques of each search, the effects it begins with and those it finds."""
    made: Searches = []
    search = DiagnosisTask.searched

    def searched(
        task: DiagnosisTask, record: Record, begun: CandidateFit | None = None, most: float = math.inf
    ) -> SearchedLog:
        found = search(task, record, begun, most)
        begins_with = frozenset() if begun is None else begun.names
        made.append((task.settings.noise.signal_tolerance, begins_with, found.explanations.chosen.names))
        return found

    monkeypatch.setattr(DiagnosisTask, "searched", searched)
    return made


def diagnosed(record: Record, robot: Robot, torque: float) -> None:
    diagnose(record, RobotWithEffects(robot, ()), tolerance={"torque": torque}, settings=FEW)


@pytest.mark.slow
def test_a_smaller_tolerance_is_reached_from_the_usual_one_with_what_was_found_there(searches: Searches) -> None:
    diagnosed(record_of_arm(imported=True), arm(), 0.01)
    (usual, nothing, found), (stated, begins_with, _) = searches
    assert (usual, stated) == (0.05, 0.01)
    assert not nothing
    assert found
    assert begins_with == found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("torque", "steps"), [(0.001, [0.05, 0.005, 0.001]), (0.0, [0.05, 0.0])], ids=["small", "exact"]
)
def test_a_step_is_no_more_than_a_tenth(torque: float, steps: list[float], searches: Searches) -> None:
    diagnosed(record_of_arm(imported=True), arm(), torque)
    assert [tolerance for tolerance, *_ in searches] == pytest.approx(steps)


@pytest.mark.slow
def test_a_larger_tolerance_is_searched_with_alone(searches: Searches) -> None:
    diagnosed(record_of_arm(imported=True), arm(), 0.08)
    assert [tolerance for tolerance, *_ in searches] == [0.08]


@pytest.mark.slow
def test_exact_torques_are_searched_once(searches: Searches) -> None:
    diagnosed(record_of("coulomb_friction@motor_1:level=0.05"), ROBOT, 0.01)
    assert len(searches) == 1


@pytest.mark.parametrize(("ahead", "hidden"), [(69.2, True), (27.0, False)])
def test_effects_may_hide_where_none_was_found_and_another_log_strays_farther_than_torques_excuse(
    ahead: float, hidden: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One sample ahead, what torques may be off by was more than a rotor of 1.4 times its inertia and cogging left."""
    monkeypatch.setattr(torque_stages, "errors_ahead", lambda *_: SimpleNamespace(mean=ahead))
    monkeypatch.setattr(torque_stages, "tolerance_floor", lambda *_: 21.7)
    found: Any = SimpleNamespace(
        explanations=SimpleNamespace(detected=False, beside=None, null=None), held_data=SimpleNamespace(settings=FEW)
    )
    assert torque_stages._may_hide(found) is hidden
    found.explanations.detected = True
    assert torque_stages._may_hide(found)


@pytest.mark.parametrize("smaller", [True, False])
def test_when_torques_acted_is_asked_again_beside_what_a_smaller_tolerance_shows(
    searches: Searches, smaller: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A delay of half a sample of a series elastic actuator showed no earlier."""
    shifts = iter((None, 0.5))
    monkeypatch.setattr(diagnose_module, "shift_of_noted", lambda *_: next(shifts))
    monkeypatch.setattr(
        diagnose_module,
        "with_smaller_tolerance",
        lambda task, found, _: (task, replace(found) if smaller else found),
    )
    result = diagnose(record_of_arm(imported=True), arm(), settings=FEW)
    assert [begins_with for _, begins_with, _ in searches] == [frozenset(), *([searches[0][2]] if smaller else [])]
    assert any("half a sample from its stamp" in warning for warning in result.diagnosis.warnings) is smaller
