"""When measured torques acted on a robot with springs, by an explanation of the log."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.gap.fit import elastic_timing
from flexros.gap.fit.elastic_timing import DELAY, shift_of_explanation
from tests.gap.diagnosis_logs import MODEL, record_of

FOUND = 1000.0
"""Sum of squares that the explanation leaves of the log as it was noted."""


def shift(
    monkeypatch: pytest.MonkeyPatch, left: dict[float, float], *, delayed: bool = False, known: float = 0.0
) -> float:
    """Return the shift of an explanation that leaves less or more of torques that act earlier or later."""
    record = record_of(length=10.0)
    measured = replace(record, noted=record.torque, measured_torque=True, imported=True, torque_shift=known)
    names = ["coulomb_friction@motor_1", *([DELAY] if delayed else [])]
    found: Any = SimpleNamespace(
        hypothesis=tuple(SimpleNamespace(name=name) for name in names),
        columns=lambda of: np.array([name in of for name in names]),
        theta=np.zeros(len(names)),
        predictor=None,
        chi2=FOUND,
    )
    data = _Data(measured)
    null: Any = SimpleNamespace(data=data, model=MODEL, predictor=lambda hypothesis: None)
    fitted = lambda predictor, moved, *_, **__: SimpleNamespace(chi2=left[moved.record.torque_shift])  # noqa: E731
    monkeypatch.setattr(elastic_timing, "fit", fitted)
    monkeypatch.setattr(elastic_timing, "replace", lambda data, record: _Data(record))
    return shift_of_explanation(found, null)


class _Data:
    """What the timing needs of a log."""

    negligible = 0.0

    def __init__(self, record: Any) -> None:
        self.record = record


@pytest.mark.parametrize(
    ("left", "expected"),
    [
        ({-0.5: 300.0, 0.5: 3000.0, -1.0: 900.0}, -0.5),
        ({-0.5: 3000.0, 0.5: 300.0, 1.0: 900.0}, 0.5),
        ({-0.5: 3000.0, 0.5: 800.0, 1.0: 900.0}, 0.0),
        ({-0.5: 3000.0, 0.5: 300.0, 1.0: 100.0}, 0.0),
    ],
    ids=["before", "after", "not clear", "rather a delay"],
)
def test_torques_act_half_a_sample_off_where_the_explanation_leaves_clearly_less(
    monkeypatch: pytest.MonkeyPatch, left: dict[float, float], expected: float
) -> None:
    assert shift(monkeypatch, left) == expected


@pytest.mark.parametrize(("least", "expected"), [(950.0, 0.5), (1050.0, 0.0)])
def test_half_a_sample_comes_before_a_delay_that_does_no_better(
    monkeypatch: pytest.MonkeyPatch, least: float, expected: float
) -> None:
    assert shift(monkeypatch, {-0.5: 9000.0, 0.5: least, 1.0: 3000.0}, delayed=True) == expected


def test_a_shift_that_is_known_is_not_sought(monkeypatch: pytest.MonkeyPatch) -> None:
    assert shift(monkeypatch, {}, known=0.5) == 0.0
