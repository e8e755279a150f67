"""What makes sizes doubtful beyond what the errors show."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.gap.fit.uncertainty.doubts import doubt_of

pytestmark = pytest.mark.slow


def test_a_shift_in_time_is_a_doubt_where_the_errors_show_it_or_leave_it_open() -> None:
    rng = np.random.default_rng(2)
    J, other = rng.standard_normal((500, 1)), rng.standard_normal(500)
    inverse = np.linalg.inv(J.T @ J)
    alike, unlike = J[:, 0], J[:, 0] + 5 * (other - J[:, 0] * (J[:, 0] @ other) / (J[:, 0] @ J[:, 0]))
    whole = float((J[:, 0] @ J[:, 0]) ** 2)
    left_open = doubt_of(alike, J, np.zeros(500), inverse)
    excluded = doubt_of(unlike, J, np.zeros(500), inverse)
    shown = doubt_of(unlike, J, unlike - alike, inverse)
    assert left_open[0, 0] == pytest.approx(whole)
    assert excluded[0, 0] < 1e-3 * whole
    assert shown[0, 0] == pytest.approx(whole, rel=0.01)
    of_another_cause = doubt_of(unlike, J, 10 * (unlike - alike), inverse)  # 1.4 samples are no half sample
    assert of_another_cause[0, 0] == pytest.approx(3 * whole, rel=0.01)
