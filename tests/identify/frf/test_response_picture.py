"""The picture of measured responses: panels, band, menus."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.frf.response_picture import ModelCurve, position_name, response_picture


@pytest.fixture(name="response")
def fixture_response() -> FrequencyResponse:
    frequency = np.array([1.0, 3.0, 5.0])
    rng = np.random.default_rng(1)
    given = rng.standard_normal((3, 2, 2)) + 1j * rng.standard_normal((3, 2, 2))
    eye = np.tile(np.eye(2, dtype=complex), (3, 1, 1))
    return FrequencyResponse(
        frequency, given, 1e-4 * eye, 4e-4 * eye, eye, 30.0, ("motor_1", "motor_2"), ("motor_1", "motor_2"),
        ("Nm", "Nm"), ("rad", "rad"), np.array([0.1, 0.2]), np.array([0.1, 0.2]), 1e-3, 2, 4,
    )  # fmt: skip


def test_positions_are_counted_from_one() -> None:
    assert position_name(2, np.array([0.2, -0.406])) == "position 3 (0.20, -0.41)"


def test_measured_response_alone_has_band_magnitude_and_phase_per_panel(response: FrequencyResponse) -> None:
    figure = response_picture([response])
    assert [note.text for note in figure.layout.annotations][1] == "motor_2 → motor_1"
    assert len(figure.data) == 4 * 3
    band, size, phase = figure.data[3:6]
    np.testing.assert_allclose(size.y, abs(response.response[:, 0, 1]), rtol=1e-3)
    np.testing.assert_allclose(band.y[:3], abs(response.response[:, 0, 1]) + 0.02, rtol=0.05)
    np.testing.assert_allclose(phase.y, np.degrees(np.angle(response.response[:, 0, 1])), rtol=1e-3)
    views = figure.layout.updatemenus[0].buttons
    assert views[1].args[0]["visible"] == [False, False, True] * 4
    assert len(figure.layout.updatemenus) == 1


def test_frequencies_follow_the_menu_of_positions_where_they_differ(response: FrequencyResponse) -> None:
    other = replace(response, frequency=response.frequency + 1)
    alike, apart = (response_picture([response, two]).layout.updatemenus[1].buttons[1] for two in (response, other))
    assert "x" not in alike.args[0]
    assert apart.args[0]["x"][:2] == [[2, 4, 6, 6, 4, 2], [2, 4, 6]]
    assert len(apart.args[0]["x"]) == len(apart.args[0]["y"]) == 12


def test_model_is_drawn_over_the_measurement_at_frequencies_of_its_own(response: FrequencyResponse) -> None:
    finer = np.linspace(2.0, 6.0, 5)
    model = ModelCurve("mine", "my model", "#000000", 1.5, finer, [np.full((5, 2, 2), 2.0 + 0j)])
    figure = response_picture([response], [model])
    line = figure.data[2]
    assert (line.name, line.mode, line.visible) == ("my model", "lines", True)
    np.testing.assert_allclose(line.x, finer)
    np.testing.assert_allclose(line.y, 2.0)
    assert figure.layout.updatemenus[0].buttons[0].args[0]["visible"] == [True, True, True, False, False] * 4


def test_model_keeps_its_frequencies_where_those_of_positions_differ(response: FrequencyResponse) -> None:
    finer = np.linspace(2.0, 6.0, 5)
    model = ModelCurve("mine", "my model", "#000000", 1.5, finer, [np.full((5, 2, 2), 2.0 + 0j)] * 2)
    other = replace(response, frequency=response.frequency + 1)
    changed = response_picture([response, other], [model]).layout.updatemenus[1].buttons[1].args[0]
    assert changed["x"][1:5] == [[2, 4, 6], finer.tolist(), [2, 4, 6], finer.tolist()]
    assert [len(x) for x in changed["x"]] == [len(y) for y in changed["y"]]
