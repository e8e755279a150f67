"""Spread of fitted parameters over new draws of the response noise: a check of the theory."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.response_noise import response_noise
from flexros.identify.graybox.fit import GrayBoxFit, fit

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.identify.graybox.problem import GrayBoxProblem


def estimated_spread(problem: GrayBoxProblem, found: GrayBoxFit, number: int, seed: int) -> FloatArray:
    """Fit responses of the fitted model plus noise of the measured covariance, drawn anew each time.

    Args:
        problem: What was fitted; its weights are kept.
        found: Where the fit ended, and each new one starts.
        number: Number of draws, at least 2.
        seed: Seed of the draws.

    Returns:
        Standard deviation of the scaled parameters over the draws, shape (P,).

    Raises:
        InputError: Fewer than two draws, or no covariance of the responses is known.
    """
    if number < 2:
        raise InputError(f"{number} draws were requested, allowed are 2 or more to estimate a spread; give more")
    model = problem.model_at(found.values).response(found.values)
    roots = [_root(response) for response in problem.responses]
    rng, rows = np.random.default_rng(seed), []
    for _ in range(number):
        drawn = tuple(
            _drawn(response, exact, root, rng)
            for response, exact, root in zip(problem.responses, model, roots, strict=True)
        )
        rows.append(problem.scale.scaled(fit(replace(problem, responses=drawn), found.values).values))
    return np.asarray(np.std(rows, axis=0, ddof=1))


def _root(response: FrequencyResponse) -> ComplexArray:
    """Square root of the covariance of vec G, shape (F, n_y n_u, n_y n_u)."""
    noise = response_noise(response)
    if noise is None:
        raise InputError("noise cannot be drawn anew, because the covariance of the responses is not known")
    values, vectors = np.linalg.eigh(noise.covariance())
    root: ComplexArray = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    return root


def _drawn(
    response: FrequencyResponse, exact: ComplexArray, root: ComplexArray, rng: np.random.Generator
) -> FrequencyResponse:
    """Add circular noise of a covariance to exact responses."""
    real, imaginary = rng.standard_normal((2, *root.shape[:2]))
    noise = np.einsum("fij,fj->fi", root, (real + 1j * imaginary) / np.sqrt(2.0))
    n_y, n_u = exact.shape[1:]
    return replace(response, response=exact + noise.reshape(-1, n_u, n_y).swapaxes(1, 2))
