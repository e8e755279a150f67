from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from flexros.report.drawing import Band, Drawing, Line, Panel

SPACE = "{http://www.w3.org/2000/svg}"
X = np.array([1.0, 10.0, 100.0])


def test_points_lie_where_the_axes_say() -> None:
    line = Line(X, np.array([0.1, 1.0, 10.0]), "#000000")
    drawing = Drawing((Panel("a < b", (1.0, 100.0), (0.1, 10.0), (line,), x_log=True),), 1, width=200, height=100)
    polyline = ET.fromstring(drawing.svg()).find(f".//{SPACE}polyline")
    assert polyline is not None
    assert polyline.get("points") == "0.0,100.0 100.0,50.0 200.0,0.0"


def test_titles_are_text_and_legends_wrap() -> None:
    panel = Panel("a < b", (0.0, 1.0), (0.0, 1.0), (), y_log=False)
    root = ET.fromstring(Drawing((panel,), 1, legend=(("first long name" * 2, "#000"), ("second" * 4, "#111"))).svg())
    texts = {text.text: float(text.get("y", "0")) for text in root.iter(f"{SPACE}text")}
    assert "a < b" in texts
    assert texts["second" * 4] > texts["first long name" * 2]


def test_values_that_are_not_finite_stay_outside() -> None:
    band = Band(X, np.array([0.0, np.nan, 1.0]), np.array([1.0, np.inf, 2.0]), "#eeeeee")
    text = Drawing((Panel("", (1.0, 100.0), (0.1, 10.0), (band,)),), 1).svg()
    assert "nan" not in text
    assert "inf" not in text


@pytest.mark.parametrize(
    ("ends", "logarithmic", "expected"),
    [((0.02, 50.0), True, ["0.1", "1", "10"]), ((1.0, 60.0), True, ["1", "2", "5", "10", "20", "50"])],
)
def test_ticks_are_round(ends: tuple[float, float], logarithmic: bool, expected: list[str]) -> None:
    root = ET.fromstring(Drawing((Panel("", ends, (1.0, 2.0), (), x_log=logarithmic),), 1).svg())
    middle = [text.text for text in root.iter(f"{SPACE}text") if text.get("text-anchor") == "middle"]
    assert middle == expected


def test_linear_ticks_are_few() -> None:
    root = ET.fromstring(Drawing((Panel("", (1.0, 100.0), (1.0, 2.0), ()),), 1).svg())
    middle = [text.text for text in root.iter(f"{SPACE}text") if text.get("text-anchor") == "middle"]
    assert middle == ["20", "40", "60", "80", "100"]
