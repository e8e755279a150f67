"""Optimal shares: proof of optimality, agreement with known optima and with another algorithm, scale."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.design.d_optimal import d_optimal


def random_information(candidates: int, size: int, seed: int = 1, rank: int = 8) -> np.ndarray:
    generator = np.random.default_rng(seed)
    factor = generator.normal(size=(candidates, size, rank)) * np.exp(generator.normal(size=(candidates, size, 1)))
    return factor @ factor.transpose(0, 2, 1)


def monomials(points: np.ndarray, degree: int) -> np.ndarray:
    rows = np.vander(points, degree + 1, increasing=True)
    return rows[:, :, None] * rows[:, None, :]


def test_quadratic_regression_has_its_known_design() -> None:
    """A parabola on [-1, 1] is measured a third of the time at -1, 0 and 1 each (Kiefer and Wolfowitz 1959)."""
    points = np.linspace(-1, 1, 201)
    design = d_optimal(monomials(points, 2))
    assert np.sort(points[design.support]) == pytest.approx([-1, 0, 1], abs=1e-9)
    assert design.weights[design.support] == pytest.approx([1 / 3] * 3, abs=1e-6)
    assert design.log_det == pytest.approx(np.log(4 / 27), abs=1e-6)


def test_equivalence_condition_and_gap_hold() -> None:
    information = random_information(300, 6)
    design = d_optimal(information)
    total = np.tensordot(design.weights, information, axes=1)
    sensitivities = np.einsum("ij,qji->q", np.linalg.inv(total), information)
    assert design.sensitivities == pytest.approx(sensitivities, rel=1e-9)
    assert sensitivities.max() == pytest.approx(6, abs=1e-6)
    assert sensitivities[design.support] == pytest.approx(np.full(len(design.support), 6.0), abs=1e-5)
    assert 0 <= design.gap < 1e-6
    assert design.dual == pytest.approx(np.linalg.inv(total), rel=1e-8)
    assert design.weights.sum() == pytest.approx(1)


@pytest.mark.slow
def test_agrees_with_the_multiplicative_algorithm() -> None:
    information = random_information(60, 4, seed=3)
    weights = np.full(60, 1 / 60)
    for _ in range(20000):
        inverse = np.linalg.inv(np.tensordot(weights, information, axes=1))
        weights *= np.einsum("ij,qji->q", inverse, information) / 4
    slow = np.linalg.slogdet(np.tensordot(weights, information, axes=1))[1]
    assert d_optimal(information).log_det == pytest.approx(slow, abs=1e-5)


def test_rounds_add_the_candidates_that_are_missing() -> None:
    """Candidates that the first rounds leave out are found by their constraints: hundreds of nearly equal ones."""
    generator = np.random.default_rng(5)
    points = generator.normal(size=(800, 5))
    points /= np.linalg.norm(points, axis=1)[:, None]
    design = d_optimal(points[:, :, None] * points[:, None, :])
    assert design.gap < 1e-6
    assert design.sensitivities.max() <= 5 + 1e-5


@pytest.mark.slow
def test_thousands_of_candidates_and_26_parameters_of_very_different_size() -> None:
    scale = np.exp(np.random.default_rng(2).normal(size=26) * 3)
    information = random_information(3000, 26, seed=2, rank=30) * np.outer(scale, scale)
    design = d_optimal(information)
    assert design.gap < 1e-6
    assert 0 < len(design.support) <= 26 * 27 / 2


def test_scaling_a_parameter_changes_nothing() -> None:
    information = random_information(50, 3)
    scale = np.diag([1e-4, 1, 1e5])
    assert d_optimal(scale @ information @ scale).weights == pytest.approx(d_optimal(information).weights, abs=1e-6)


def test_prior_makes_undetermined_parameters_harmless() -> None:
    information = random_information(40, 4)
    information[:, 3, :] = information[:, :, 3] = 0
    design = d_optimal(information, prior=np.diag([0, 0, 0, 0.5]))
    three = d_optimal(information[:, :3, :3])
    assert design.weights == pytest.approx(three.weights, abs=1e-5)
    assert design.sensitivities.max() == pytest.approx(3, abs=1e-5)


def test_parameter_that_nothing_determines_is_named() -> None:
    information = random_information(20, 3)
    information[:, 1, :] = information[:, :, 1] = 0
    with pytest.raises(InputError, match=r"no candidate position distinguishes parameter 2 of 3 from the others"):
        d_optimal(information)
