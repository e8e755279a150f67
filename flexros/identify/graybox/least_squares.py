"""Least squares of a model and measured frequency responses: compiled where possible, else NumPy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.identify.graybox.kernel.frequency_model import compiled_model
from flexros.identify.graybox.kernel.least_squares import CompiledLeastSquares
from flexros.identify.graybox.numpy_least_squares import AbstractLeastSquares, NumpyLeastSquares, ResponseTarget

if TYPE_CHECKING:
    from flexros.identify.graybox.frequency_model import FrequencyModel

__all__ = ["AbstractLeastSquares", "ResponseTarget", "least_squares"]


def least_squares(model: FrequencyModel, target: ResponseTarget, threads: int = 1) -> AbstractLeastSquares:
    """Set up the least squares of a model and measured responses, in machine code where it can be compiled.

    Args:
        model: Frequency model.
        target: Measured responses, weights and estimator.
        threads: Threads that share the positions, for compiled code.

    Raises:
        InputError: The target does not match the model.
    """
    target.check(model)
    compiled = compiled_model(model, threads)
    return NumpyLeastSquares(model, target) if compiled is None else CompiledLeastSquares(compiled, target)
