"""When most of what an answer leaves happened, where that is short."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.gap.answer.short_events import resonance, short_events, spans
from flexros.gap.schema import GapNumbers
from tests.gap.diagnosis_logs import WHOLE, data_of

if TYPE_CHECKING:
    from flexros.gap.residuals.fit_data import FitData


@pytest.fixture
def fit() -> Any:
    class Fit:
        """What leaves noise, and more in some samples."""

        def __init__(self) -> None:
            self.more = np.zeros(0)

        def residual(self, data: Any) -> np.ndarray:
            n, M = data.record.position.shape
            left = np.random.default_rng(1).normal(size=(M, n))
            left[0, : len(self.more)] += self.more
            return left.ravel()

    return Fit()


def test_a_push_is_told_with_its_time(fit: Any) -> None:
    data = data_of(length=WHOLE)
    n, T = data.record.n_samples, data.record.sample_time
    fit.more = np.zeros(n)
    fit.more[n // 2 : n // 2 + round(0.1 / T)] = 30.0
    ((first, last),) = spans(data, fit)
    assert first <= n // 2 * T <= last
    assert last - first <= 0.5


def test_what_is_left_everywhere_or_hardly_at_all_is_no_event(fit: Any) -> None:
    data = data_of(length=WHOLE)
    assert spans(data, fit) == []
    fit.more = np.full(data.record.n_samples, 3.0)
    assert spans(data, fit) == []


def gap(after: float) -> GapNumbers:
    return GapNumbers(metric="", unit="1", before=100.0, after=after, noise_floor=1.0, closed_fraction=None)


def told(data: FitData, fit: Any, after: float) -> list[str]:
    explanations = SimpleNamespace(chosen=fit)
    findings = SimpleNamespace(
        data=data, held=data, explanations=explanations, held_chosen=fit, settings=data.settings.ranking
    )
    return short_events(findings, gap(after))  # type: ignore[arg-type]


def pushed(data: FitData, fit: Any, at: float) -> None:
    n, T = data.record.n_samples, data.record.sample_time
    fit.more = np.zeros(n)
    fit.more[round(at * n) :][: round(0.1 / T)] = 30.0


def test_a_push_is_no_event_where_the_gap_is_within_its_floor(fit: Any) -> None:
    data = data_of(length=WHOLE)
    pushed(data, fit, 0.5)
    assert len(told(data, fit, after=30.0)) == 2
    assert told(data, fit, after=1.2) == []


def test_what_is_left_at_the_end_of_a_log_is_no_event(fit: Any) -> None:
    data = data_of(length=WHOLE)
    fit.more = np.zeros(data.record.n_samples)
    fit.more[-1] = 3e3
    assert spans(data, fit) == []


def test_times_of_a_long_log_are_told_apart(fit: Any) -> None:
    """A part of a quarter of a second had been that from 1202 to 1202 s."""
    data = data_of(length=WHOLE)
    pushed(data, fit, 0.5)
    ((first, last),) = spans(data, fit)
    text, _ = told(replace(data, record=replace(data.record, begin=1200.0)), fit, after=30.0)
    assert f"within {1200 + first:.10g} to {1200 + last:.10g} s" in text


def test_an_error_of_the_initial_state_is_no_event(fit: Any) -> None:
    """A log that begins in motion: the first samples of a clean one had been a push."""
    data = data_of(length=WHOLE)
    assert data.gain.settling > 10
    fit.more = np.zeros(data.record.n_samples)
    fit.more[:10] = 100.0
    assert spans(data, fit) == []


def swept(data: FitData, lowest: float, highest: float) -> tuple[FitData, np.ndarray, np.ndarray]:
    """Return the log with commands whose frequency sweeps, that frequency [Hz], and the sweep, shape (n,)."""
    n, T = data.record.n_samples, data.record.sample_time
    frequency = lowest * (highest / lowest) ** np.linspace(0, 1, n)
    sweep = np.sin(2 * np.pi * np.cumsum(frequency) * T)
    slews = 4.0 * np.sin(2 * np.pi * 0.4 * T * np.arange(n))
    torque = data.record.torque.copy()
    torque[:, 0] = sweep + slews
    return replace(data, record=replace(data.record, torque=torque)), frequency, sweep


@pytest.mark.parametrize(("lowest", "highest"), [(8.0, 60.0), (60.0, 8.0)])
def test_a_sweep_that_passes_a_resonance_is_told_and_not_to_be_cut_out(lowest: float, highest: float, fit: Any) -> None:
    data, frequency, sweep = swept(data_of(length=WHOLE), lowest, highest)
    begin = data.record.n_samples // 2
    fit.more = np.zeros(data.record.n_samples)
    length = round(0.25 / data.record.sample_time)
    fit.more[begin : begin + length] = 30.0 * sweep[begin : begin + length]
    (part,) = spans(data, fit)
    at = resonance(data, fit, part)
    assert at == pytest.approx(frequency[begin + length // 2], rel=0.1)
    text, _ = told(data, fit, after=30.0)
    assert f"resonance at about {at:.3g} Hz" in text
    assert "take these samples out" not in text


def test_a_push_during_a_sweep_and_a_robot_that_rings_pass_no_resonance(fit: Any) -> None:
    data, _, _ = swept(data_of(length=WHOLE), 8.0, 60.0)
    pushed(data, fit, 0.5)
    (part,) = spans(data, fit)
    assert resonance(data, fit, part) is None
    n, T = data.record.n_samples, data.record.sample_time
    ringing = np.where(np.arange(n) >= n // 2, np.exp(-(np.arange(n) - n // 2) * T / 0.1), 0.0)
    ringing *= np.sin(2 * np.pi * 22.0 * T * np.arange(n))
    torque = data.record.torque.copy()
    torque[:, 0] = ringing
    fit.more = 300.0 * ringing
    rung = replace(data, record=replace(data.record, torque=torque))
    for part in spans(rung, fit):
        assert resonance(rung, fit, part) is None
