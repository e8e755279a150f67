"""Scales of all torques of an arm without gravity."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.gap.search.proportion import other_scales
from tests.gap.planar_arm import FRICTION, fitted, searched

if TYPE_CHECKING:
    from pathlib import Path


GAINS = tuple(f"torque_gain_error@motor_{k}" for k in (1, 2, 3))


def test_one_gain_takes_the_place_of_those_of_all_other_motors(tmp_path: Path) -> None:
    """A gain of the shoulder that was 8 % too small had been named as two too large ones, in an arm too heavy."""
    search = searched(tmp_path, *FRICTION, f"{GAINS[0]}:relative=-0.08")
    friction = tuple(one.partition(":")[0] for one in FRICTION)
    hypothesis = fitted(search, *friction, *GAINS[1:])
    predictor = search.null.predictor(hypothesis)
    sizes = [1.63, 0.87, 0.435, 0.087, 0.087]
    encoded = [one.free[0].encode(size) for one, size in zip(hypothesis, sizes, strict=True)]
    start = np.concatenate([encoded, np.zeros(predictor.tolerance.n_free)])
    wrong = search.completed(replace(search.null.fit, predictor=predictor, theta=start))
    (begun,) = other_scales(search, wrong)
    right = search.completed(begun)
    assert right.names == {*friction, GAINS[0]}
    assert right.chi2 < wrong.chi2
    found = dict(zip((one.name for one in right.hypothesis), right.predictor.values(right.theta), strict=True))
    assert found[GAINS[0]]["relative"] == pytest.approx(-0.08, abs=0.02)
    assert found[friction[0]]["level"] == pytest.approx(1.5, rel=0.05)


def test_more_gains_than_before_are_not_tried(tmp_path: Path) -> None:
    """One gain of three that is wrong is simpler than two that are."""
    search = searched(tmp_path, *FRICTION, f"{GAINS[0]}:relative=-0.08")
    hypothesis = fitted(search, GAINS[0])
    predictor = search.null.predictor(hypothesis)
    start = np.concatenate([[hypothesis[0].free[0].encode(-0.08)], np.zeros(predictor.tolerance.n_free)])
    assert not list(other_scales(search, replace(search.null.fit, predictor=predictor, theta=start)))
