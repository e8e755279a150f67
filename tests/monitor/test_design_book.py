"""Designs for poses: cells, memory, noise that is known."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import parse_effect
from flexros.effects.patching.patched_robot import load_model
from flexros.errors import InputError
from flexros.monitor import design_book
from flexros.monitor.design_book import DesignBook, known_noise


def test_poses_of_a_linear_robot_share_one_design() -> None:
    model = load_model("four_mass_linear")
    book = DesignBook(model, 5e-4, 200)
    assert book.cell(np.array([7.0])) == book.cell(np.array([0.0])) == book.home


def test_a_design_is_made_once() -> None:
    book = DesignBook(load_model("elbow"), 5e-4, 200)
    cell = book.cell(np.array([0.9, -0.4]))
    assert book.at(cell) is book.at(cell)
    assert book.made == 1


def test_memory_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(design_book, "MOST", 3)
    book = DesignBook(load_model("elbow"), 5e-4, 200)
    for place in range(5):
        book.at((0, place))
    assert len(book._kept) == 3
    assert book.made == 5


def test_rounding_that_is_known_counts_as_noise() -> None:
    model = load_model("e12").with_effects([parse_effect("encoder_quantization@motor_2:step=1e-5", "test")])
    np.testing.assert_allclose(known_noise(model), [2e-6, np.hypot(2e-6, 5e-6)])


def test_a_robot_without_encoder_noise_is_refused() -> None:
    model = load_model("e12")
    object.__setattr__(model, "robot", type("Quiet", (), {"name": "quiet", "encoder_noise": np.zeros(2)})())
    with pytest.raises(InputError, match=r"^robot quiet states encoder noise of \[0.0, 0.0\] .* give sensors.encoder"):
        known_noise(model)
