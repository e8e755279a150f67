"""The patch of a diagnosis is held against a log that neither fit nor check has seen."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.gap.schema import CauseParameter
from flexros.random_streams import Stream
from flexros.validation.blind.diagnose_case import PATCH_FILE
from flexros.validation.blind.make_case import MakeSettings, make_case
from flexros.validation.blind.plan import Case
from flexros.validation.blind.score.coverage import covers
from flexros.validation.blind.score.score import score
from flexros.validation.blind.score.third_log import ThirdLog, third_log
from flexros.validation.blind.seal import Truth, read_case
from tests.validation.blind.cases import diagnosis, truth

SETTINGS = MakeSettings(3, Stream.BLIND_DEVELOPMENT, (4.0, 4.0, 6.0))
CASE = Case(2, "single", "four_mass_linear", ("torque_bias",), "strong", "exact", False)
PATCH = "robot: robot.yaml\neffects:\n  - effect: torque_bias\n    location: {at}\n    parameters: {{level: {level}}}\n"


@pytest.mark.slow
def test_a_patch_is_tried_on_the_third_log(tmp_path: Path) -> None:
    make_case(CASE, SETTINGS, tmp_path / "logs", tmp_path / "truth")
    hidden = Truth.model_validate_json((tmp_path / "truth" / "case_0002.json").read_bytes())
    folder = tmp_path / "logs" / "case_0002"
    case = read_case(folder)
    assert third_log(folder, case) is None
    level = hidden.deviations[0].parameters["level"]
    for size, share in ((level, 1.0), (0.5 * level, 0.75)):
        (folder / PATCH_FILE).write_text(PATCH.format(level=size, at="motor_1"), encoding="utf-8")
        found = third_log(folder, case)
        assert found is not None
        assert found.closed_fraction == pytest.approx(share, abs=0.03)
    (folder / PATCH_FILE).write_text(PATCH.format(level=level, at="motor_9"), encoding="utf-8")
    failed = third_log(folder, case)
    assert failed is not None
    assert "motor_9" in failed.failure


def test_patches_that_fail_count_as_not_closing_the_gap() -> None:
    from flexros.validation.blind.score.answer import Answer

    hidden, said = truth("single", "delay@all"), diagnosis("explained", "delay@all")
    thirds = [
        ThirdLog(before=50.0, after=1.1, closed_fraction=0.998),
        ThirdLog(before=50.0, after=10.0, closed_fraction=0.8),
        ThirdLog(before=1.0, after=1.0),
        ThirdLog(failure="no such place"),
        None,
    ]
    found = score([Answer(hidden, said, 1.0, None, third) for third in thirds])
    assert (found.third_95.hits, found.third_95.cases) == (1, 3)
    assert found.closed_third == pytest.approx(0.899)


def test_the_best_impostor_is_told_by_what_it_closes() -> None:
    from flexros.validation.blind.score.answer import Answer

    said = diagnosis("explained", "delay@all")
    gap = said.gap.model_copy(update={"before": 11.0, "best_rival": 4.0, "closed_fraction": 0.95})
    one = Answer(truth("single", "delay@all"), said.model_copy(update={"gap": gap}))
    assert one.closed_rival == pytest.approx(0.7)
    found = score([one])
    assert (found.closed_rival, found.margin) == (pytest.approx(0.7), pytest.approx(0.25))


@pytest.mark.parametrize(
    ("effect", "name", "value", "std", "true", "inside"),
    [
        ("torque_bias", "level", 1.0, 0.5, 0.1, True),
        ("torque_bias", "level", 0.2, 0.1, -0.1, False),
        ("delay", "time", 1.0, 0.5, 2.5, True),
        ("delay", "time", 1.0, 0.5, 0.1, False),
        ("delay", "time", 1.0, 0.01, 1.1, False),
    ],
)
def test_intervals_are_those_of_the_number_that_was_fitted(
    effect: str, name: str, value: float, std: float, true: float, inside: bool
) -> None:
    assert covers(effect, name, CauseParameter(value=value, std=std, unit="1"), true) is inside
