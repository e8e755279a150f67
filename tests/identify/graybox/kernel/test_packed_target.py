"""Measured responses in the order of the compiled code."""

from __future__ import annotations

import numpy as np

from flexros.identify.graybox.numpy_least_squares import ResponseTarget


def target(estimator: str) -> ResponseTarget:
    rng = np.random.default_rng(0)
    response = rng.normal(size=(2, 5, 2, 2)) + 1j * rng.normal(size=(2, 5, 2, 2))
    weights = rng.uniform(1, 2, response.shape)
    weights[0, 1] = 0.0
    return ResponseTarget(response, weights, estimator)


def test_pairs_hold_both_elements_and_the_sum_of_their_weights() -> None:
    given = target("NLS")
    packed = given.packed.reshape(2, 1, 3, 8, 8)[1, 0, 1, :, 3]
    (a, b), (v, w) = (array[1, 3, [0, 1], [1, 0]] for array in (given.response, given.weights))
    np.testing.assert_allclose(packed, [a.real, a.imag, v, b.real, b.imag, w, np.sqrt(v + w), 1 / np.sqrt(v + w)])


def test_diagonal_elements_count_once() -> None:
    given = target("LLS")
    packed = given.packed.reshape(2, 1, 3, 8, 8)[1, 0, 2, :, 0]
    log, w = np.log(given.response[1, 0, 1, 1]), given.weights[1, 0, 1, 1]
    np.testing.assert_allclose(packed[[0, 1, 2, 5, 6]], [log.real, log.imag, w, 0.0, np.sqrt(w)])


def test_elements_without_weight_and_padding_count_for_nothing() -> None:
    packed = target("LLS").packed.reshape(2, 1, 3, 8, 8)
    assert np.all(packed[0, 0, :, [2, 5, 6, 7], 1] == 0.0)
    assert np.all(packed[..., 5:] == 0.0)
    assert np.all(np.isfinite(packed))


def test_a_target_is_packed_once() -> None:
    given = target("LLS")
    assert given.packed is given.packed
