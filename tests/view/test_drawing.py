from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.view.drawing import evenly, magnification, ribbon, turned_z


def test_bars_are_turned_onto_their_direction() -> None:
    directions = np.array([[1.0, 0, 0], [0, 2.0, 0], [0, 0, 3.0], [0, 0, -1.0], [1.0, -2.0, 0.5]])
    turned = Rotation.from_quat(turned_z(directions)[:, [1, 2, 3, 0]]).apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(turned, directions / np.linalg.norm(directions, axis=1, keepdims=True), atol=1e-12)


def test_ribbon_lies_between_path_and_magnified_error() -> None:
    base = np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]])
    corners, faces = ribbon(base, np.full((3, 3), [0.0, 0.0, 1e-3]), 100)
    np.testing.assert_allclose(corners[3:, 2], 0.1)
    sides = corners[faces]
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]), axis=1).sum()
    assert area == pytest.approx(0.2)


@pytest.mark.parametrize(("deviation", "factor"), [(1e-3, 100), (0.5, 1), (1e-9, 5000), (0.02, 5)])
def test_magnification_makes_the_deviation_visible(deviation: float, factor: int) -> None:
    assert magnification(deviation, 1.0) == factor


def test_rows_keep_first_and_last() -> None:
    rows = evenly(10_001, 100)
    assert len(rows) == 100
    assert (rows[0], rows[-1]) == (0, 10_000)
