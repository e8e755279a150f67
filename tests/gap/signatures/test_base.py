"""The registry of pictures, and what all of them have in common."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.signatures.base import MOST_POINTS, binned, pictures_for, signatures, thinned
from flexros.gap.signatures.signature_data import SignatureData


@pytest.mark.parametrize("effect", sorted(effects()))
def test_every_effect_has_a_picture(effect: str) -> None:
    assert effects()[effect].signatures
    assert [kind.name for kind in pictures_for(effect)] == list(effects()[effect].signatures)


def test_every_picture_shows_an_effect() -> None:
    assert {name for effect in effects().values() for name in effect.signatures} == set(signatures())


def test_the_clearest_picture_comes_first() -> None:
    assert pictures_for("coulomb_friction")[0].name == "torque_over_speed"
    assert pictures_for("torque_ripple")[0].name == "order_spectrum"
    assert pictures_for("delay")[0].name == "time_shift"
    assert pictures_for("backlash")[0].name == "torsion_over_torque"


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(signatures()))
def test_pictures_are_small_and_described(name: str, friction: SignatureData) -> None:
    picture = signatures()[name]().picture(friction, "motor_1")
    if name in ("tool_error", "detection_lines"):
        assert picture is None  # the tool was not measured, and no part of the log is periodic
        return
    assert picture is not None
    assert picture.series
    assert "motor_1" in picture.title
    assert "[" in picture.x_label
    assert "[" in picture.y_label
    assert picture.reading.endswith(".")
    for curve in picture.series.values():
        assert 0 < len(curve.x) == len(curve.y) <= MOST_POINTS
        assert np.all(np.isfinite(curve.x))
        assert np.all(np.isfinite(curve.y))


def test_thinning_keeps_peaks() -> None:
    y = np.zeros(100_000)
    y[54_321] = 5.0
    x, kept = thinned(np.arange(100_000.0), y)
    assert len(kept) <= MOST_POINTS
    assert kept.max() == 5.0
    assert np.all(np.diff(x) > 0)


def test_binning_averages() -> None:
    x, y = binned(np.linspace(0, 1, 1001), np.linspace(0, 2, 1001), 10)
    assert y == pytest.approx(2 * x)
    assert len(x) == 10
