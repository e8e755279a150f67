"""The same fit from many starts, on threads of one machine or on a Dask cluster (Moberg 2007, Paper A, section 5.3)."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.graybox.fit import Fit, FitSettings, fit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from distributed import Client

    from flexros.arrays import FloatArray
    from flexros.identify.graybox.problem import GrayBoxProblem


def random_starts(problem: GrayBoxProblem, number: int, seed: int, decades: float = 1.0) -> FloatArray:
    """Draw starts around the robot's values: theta = theta_robot 10^phi with phi uniform in [-decades, decades].

    Parameters that are not logarithmic start at their value plus phi times their typical size.

    Args:
        problem: The unknown parameters.
        number: Number of starts; the first ones do not depend on it.
        seed: Seed of the random numbers.
        decades: Largest |phi|.

    Returns:
        Starts [SI], shape (number, P).

    Raises:
        InputError: The number is not positive.
    """
    if number < 1:
        raise InputError(f"{number} random starts were asked for, allowed is 1 or more; give a positive number")
    scale = problem.scale
    phi = np.random.default_rng(seed).uniform(-decades, decades, (number, len(scale.names)))
    drawn = np.where(scale.logarithmic, scale.nominal * 10.0**phi, scale.nominal + phi * scale.size)
    return np.maximum(drawn, scale.lowest)


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
) -> tuple[Fit, ...]:
    """Fit from many starts. Results do not depend on threads or scheduler.

    Args:
        problem: What to fit.
        starts: Starts [SI], shape (S, P), or the number of random starts; see `random_starts`.
        seed: Seed of random starts.
        bounds: Bounds of all fits; see `fit`.
        settings: How each fit searches.
        threads: Threads of this process; default: one per processor.
        client: Dask client whose workers fit instead.
        progress: Called with the number of fits done.

    Returns:
        Fits in the order of their starts.

    Raises:
        InputError: Wrong starts or bounds.
    """
    chosen = random_starts(problem, starts, seed) if isinstance(starts, int) else np.asarray(starts, dtype=float)
    if client is not None:
        return _on_cluster(problem, chosen, bounds, settings, client, progress)
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        try:
            return _collected(pool.map(lambda start: fit(problem, start, bounds, settings), chosen), progress)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def best(fits: Sequence[Fit]) -> Fit:
    """Return the fit of lowest cost; among equal ones the first.

    Args:
        fits: Fits of one problem.

    Raises:
        InputError: There is none.
    """
    if not fits:
        raise InputError("no fit was given to choose the best from; fit from one start at least")
    return min(fits, key=lambda each: each.cost)


def _on_cluster(
    problem: GrayBoxProblem,
    starts: FloatArray,
    bounds: Mapping[str, tuple[float, float]] | None,
    settings: FitSettings | None,
    client: Client,
    progress: Callable[[int], None] | None,
) -> tuple[Fit, ...]:
    shared = client.scatter(problem, broadcast=True, hash=False)
    jobs = [client.submit(fit, shared, start, bounds, settings, pure=False) for start in starts]
    try:
        return _collected((job.result() for job in jobs), progress)
    except BaseException:
        client.cancel(jobs)
        raise


def _collected(results: Iterable[Fit], progress: Callable[[int], None] | None) -> tuple[Fit, ...]:
    fits = []
    for result in results:
        fits.append(result)
        if progress is not None:
            progress(len(fits))
    return tuple(fits)
