"""Fits from many initial values, on threads or on a Dask cluster (Moberg 2007, Paper A, section 5.3)."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np

from flexros.blas_threads import one_blas_thread
from flexros.errors import InputError, RunError
from flexros.identify.graybox.fit import FitSettings, GrayBoxFit, fit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from distributed import Client

    from flexros.arrays import FloatArray
    from flexros.identify.graybox.problem import GrayBoxProblem


def random_starts(
    problem: GrayBoxProblem,
    number: int,
    seed: int,
    decades: float = 1.0,
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> FloatArray:
    """Draw initial values around the nominal ones: theta = theta_robot 10^phi with phi uniform in [-decades, decades].

    Parameters that are not logarithmic start at their value plus phi times their typical size. Where bounds cut that
    range, phi is uniform in the remaining range; a nominal value outside its bounds is replaced by the nearer bound.

    Args:
        problem: Problem with the unknown parameters.
        number: Number of draws; the first ones do not depend on it.
        seed: Seed of the random numbers.
        decades: Largest |phi|.
        bounds: Bounds of the fits; see `ParameterScale.bounds` for the default.

    Returns:
        Initial values [SI], shape (number, P).

    Raises:
        InputError: `number` is not positive, or the bounds are wrong.
    """
    if number < 1:
        raise InputError(f"{number} random starts were requested, allowed is 1 or more; give a positive number")
    scale = problem.scale
    lower, upper = scale.bounds(bounds)
    centre = np.clip(scale.scaled(scale.nominal), lower, upper)
    reach = decades * np.where(scale.logarithmic, np.log(10.0), 1.0)
    low, high = np.maximum(lower, centre - reach), np.minimum(upper, centre + reach)
    share = np.random.default_rng(seed).random((number, len(scale.names)))
    return scale.values(low + share * (high - low))


def multistart(
    problem: GrayBoxProblem,
    starts: FloatArray | int,
    *,
    seed: int = 0,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    settings: FitSettings | None = None,
    threads: int | None = None,
    client: Client | None = None,
    progress: Callable[[int], None] | None = None,
) -> tuple[GrayBoxFit, ...]:
    """Fit from many initial values. Results do not depend on threads or scheduler.

    Args:
        problem: Measured responses, unknown parameters, estimator and weights.
        starts: Initial values [SI], shape (S, P), or the number of random ones; see `random_starts`.
        seed: Seed of random initial values.
        bounds: Bounds of all fits, and of random initial values; see `fit`.
        settings: Search settings of each fit.
        threads: Threads of this process; default: one per processor.
        client: Dask client whose workers fit instead.
        progress: Called with the number of completed fits.

    Returns:
        Fits in the order of their initial values.

    Raises:
        InputError: Wrong initial values or bounds.
    """
    if isinstance(starts, int):
        starts = random_starts(problem, starts, seed, bounds=bounds)
    initial = np.asarray(starts, dtype=float)
    if client is not None:
        return _on_cluster(problem, initial, bounds, settings, client, progress)
    with one_blas_thread(), ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        try:
            return _collected(pool.map(lambda start: fit(problem, start, bounds, settings), initial), progress)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def best(fits: Sequence[GrayBoxFit]) -> GrayBoxFit:
    """Return the fit of lowest cost, the first among equal ones; failed fits, without a finite cost, are skipped.

    Raises:
        InputError: No fit was given.
        RunError: All of them failed.
    """
    if not fits:
        raise InputError("no fit was given to choose the best from; fit from at least one start")
    done = [fit for fit in fits if np.isfinite(fit.cost)]
    if not done:
        raise RunError(
            f"all {len(fits)} fits failed, because the model cannot be evaluated at their starts: {fits[0].message}; "
            "give other starts, narrower bounds, or correct the robot"
        )
    return min(done, key=lambda fit: fit.cost)


def _on_cluster(
    problem: GrayBoxProblem,
    starts: FloatArray,
    bounds: Mapping[str, tuple[float, float]] | None,
    settings: FitSettings | None,
    client: Client,
    progress: Callable[[int], None] | None,
) -> tuple[GrayBoxFit, ...]:
    shared = client.scatter(problem, broadcast=True, hash=False)
    jobs = [client.submit(fit, shared, start, bounds, settings, pure=False) for start in starts]
    try:
        return _collected((job.result() for job in jobs), progress)
    except BaseException:
        client.cancel(jobs)
        raise


def _collected(results: Iterable[GrayBoxFit], progress: Callable[[int], None] | None) -> tuple[GrayBoxFit, ...]:
    fits = []
    for result in results:
        fits.append(result)
        if progress is not None:
            progress(len(fits))
    return tuple(fits)
