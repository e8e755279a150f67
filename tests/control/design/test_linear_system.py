"""Linear systems by their matrices."""

from __future__ import annotations

import numpy as np

from flexros.control.design.continuous import ContinuousSystem
from flexros.control.design.fixed_structure import DiscreteSystem, biquad_system, pid_system

FREQUENCY = np.array([0.5, 3.0, 20.0])


def test_the_response_of_systems_in_series_is_the_product() -> None:
    first = ContinuousSystem.of_polynomials([1.0, 2.0], [1.0, 3.0, 9.0])
    second = ContinuousSystem.of_polynomials([4.0], [1.0, 5.0])
    both = first.then(second)
    assert both.order == 3
    assert isinstance(both, ContinuousSystem)
    np.testing.assert_allclose(both.response(FREQUENCY), second.response(FREQUENCY) * first.response(FREQUENCY))


def test_so_it_is_of_discrete_ones() -> None:
    T = 1e-3
    first, second = pid_system(3.0, 1.0, 0.1, 0.01, T), biquad_system(30.0, 0.1, 40.0, 0.7, T)
    both = first.then(second)
    assert isinstance(both, DiscreteSystem)
    product = second.response(FREQUENCY, T) * first.response(FREQUENCY, T)
    np.testing.assert_allclose(both.response(FREQUENCY, T), product)
