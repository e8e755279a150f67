"""Solutions of least norm of symmetric systems."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.gap.fit.least_norm import least_norm


@pytest.mark.parametrize("converges", [True, False])
@pytest.mark.parametrize("columns", [(), (2,)])
def test_directions_without_information_stay_zero(
    converges: bool, columns: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where singular values do not converge, eigenvalues give the same."""
    rng = np.random.default_rng(1)
    slopes = rng.normal(size=(50, 4))
    slopes[:, 3] = slopes[:, 0]  # two parameters that do the same
    right = slopes.T @ rng.normal(size=(50, *columns))

    def fails(*_: Any, **__: Any) -> None:
        raise np.linalg.LinAlgError("SVD did not converge in Linear Least Squares")

    if not converges:
        monkeypatch.setattr(np.linalg, "lstsq", fails)
    found = least_norm(slopes.T @ slopes, right, 1e-12)
    np.testing.assert_allclose(slopes.T @ slopes @ found, right, atol=1e-9)
    np.testing.assert_allclose(found[3], found[0], atol=1e-9)
