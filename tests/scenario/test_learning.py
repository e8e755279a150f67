from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.scenario.experiment import Experiment
from flexros.scenario.learning import LearningSettings, learn
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow


def experiment(name: str, **values: Any) -> Experiment:
    return Experiment.prepare(load_scenario(name).with_values({"noise": True, **values}))


@pytest.mark.parametrize("name", ["circle_fj", "circle_pd"])
def test_circle_is_learned_to_the_published_accuracy(name: str) -> None:
    """Moberg (2007), section 5.5: better than 0.15 mm, 0.05 mm on average."""
    result = learn(experiment(name), LearningSettings(trials=7, bandwidth=80.0))
    assert 1e3 * result.largest[0] > 2.0
    assert 1e3 * result.largest[-1] < 0.15
    assert 1e3 * result.rms[-1] < 0.05


def test_an_unknown_load_is_learned() -> None:
    loaded = experiment("circle_dae", **{"plant.values": {"body_3.mass": 210}})
    result = learn(loaded, LearningSettings(trials=5))
    assert 1e3 * result.largest[0] > 1.3
    assert 1e3 * result.largest[-1] < 0.15
    assert np.all(np.diff(result.largest[:4]) < 0)


def test_exact_feedforward_has_nothing_to_learn() -> None:
    exact = experiment("smooth_dae2", noise=False)
    result = learn(exact, LearningSettings(trials=3))
    assert 1e3 * result.largest.max() < 0.05


def test_experiment_itself_is_not_changed() -> None:
    one = experiment("circle_fj")
    before = one.reference.motor_position.copy()
    result = learn(one, LearningSettings(trials=2))
    np.testing.assert_array_equal(one.reference.motor_position, before)
    assert np.abs(result.reference.motor_position - before).max() > 1e-4


@pytest.mark.parametrize(
    ("name", "settings", "sentence"),
    [
        ("elbow_moves", LearningSettings(), "no path of tool positions"),
        ("circle_fj", LearningSettings(bandwidth=5000.0), "bandwidth is 5000 Hz"),
        ("circle_fj", LearningSettings(trials=1), "at least 2"),
        ("circle_fj", LearningSettings(gain=1.5), "gain is 1.5"),
        ("circle_stable_inversion", LearningSettings(trials=2), "non-minimum phase"),
    ],
)
def test_what_cannot_be_learned_is_refused(name: str, settings: LearningSettings, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        learn(experiment(name), settings)
