from __future__ import annotations

import numpy as np
import pytest

from flexros.analysis.cycles import Cycle
from flexros.analysis.point_to_point import stops

T = 1e-3


def move(ringing: float, decay: float = 10.0, offset: float = 0.0) -> Cycle:
    """A move of 50 mm in 0.2 s that starts at 0.1 s, with a vibration of 10 Hz after it, held for 0.7 s."""
    time = np.arange(1000) * T
    commanded = np.zeros((1000, 3))
    commanded[:, 0] = 0.05 * np.clip((time - 0.1) / 0.2, 0.0, 1.0)
    attained = commanded.copy()
    after = np.clip(time - 0.3, 0.0, None)
    attained[:, 0] += np.where(after > 0, ringing * np.exp(-decay * after) * np.cos(20 * np.pi * after), 0.0) + offset
    return Cycle(time, commanded, attained)


def test_exact_move_is_settled_when_the_command_stops() -> None:
    (stop,) = stops(move(0.0))
    assert stop.time == pytest.approx(0.3, abs=2 * T)
    assert stop.positioning == pytest.approx(0.2 - 0.2 * 0.3e-3 / 0.05, abs=2 * T)
    assert stop.settling == 0.0
    assert stop.overshoot == 0.0


def test_vibration_settles_when_its_envelope_enters_the_band() -> None:
    (stop,) = stops(move(2e-3))
    # peaks every 50 ms: 2 mm exp(-10 t) is below 0.3 mm from t = 0.1897 s on; the last peak beyond is at 0.15 s
    assert 0.15 < stop.settling < 0.19
    assert stop.positioning == pytest.approx(stop.settling + 0.2, abs=2 * T)
    assert stop.overshoot == pytest.approx(2e-3 * np.exp(-0.5), rel=0.2) or stop.overshoot == pytest.approx(
        2e-3, rel=0.1
    )
    assert 0.0 < stop.stabilisation <= stop.settling + 0.01


def test_constant_error_does_not_matter() -> None:
    """The band is about the attained position (ISO 9283), not about the commanded one."""
    (stop,) = stops(move(0.0, offset=5e-3))
    assert stop.settling == 0.0


def test_undamped_vibration_never_settles() -> None:
    (stop,) = stops(move(2e-3, decay=0.0))
    assert stop.positioning is None
    assert stop.overshoot is None


def test_way_hardly_longer_than_the_band_settles() -> None:
    """The middle of the way is in the band, in which the tool still moves at the end."""
    run = move(0.0)
    attained = 0.35e-3 / 0.05 * run.commanded
    attained[300:, 0] -= 0.2e-3 * np.cos(20 * np.pi * run.time[300:])  # whole periods in the last fifth of the rest
    (stop,) = stops(Cycle(run.time, run.commanded, attained))
    assert 0.0 <= stop.settling < 0.2
    assert stop.overshoot == 0.0


def test_every_stop_counts_but_no_short_rest() -> None:
    once = move(0.0)
    time = np.arange(2000) * T
    back = once.commanded[::-1]
    commanded = np.concatenate([once.commanded, back])
    assert len(stops(Cycle(time, commanded, commanded))) == 2
    short = np.concatenate([once.commanded[:310], once.commanded[:310][::-1], np.zeros((380, 3))])
    assert len(stops(Cycle(time[:1000], short, short))) == 1
