"""A CasADi function, evaluated at many samples on arrays of NumPy themselves.

A call with arrays copies them into matrices of CasADi and these, number by number, back again, which takes ten times as
long as a model of some hundred operations itself. Nothing is compiled, and results are equal to the last bit.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import casadi as ca

    from flexros.arrays import FloatArray

SAMPLES = 100_000
"""Most samples side by side in one call (chosen): CasADi notes the place of each of their numbers."""


def over_rows(function: ca.Function, *rows: FloatArray) -> tuple[FloatArray, ...]:
    """Evaluate a function of dense column vectors at n samples.

    Args:
        function: The function; its outputs are dense, vectors or matrices.
        rows: Each input, shape (n, size).

    Returns:
        Each output, shape (n, size), or (n, rows, columns) of a matrix.
    """
    inputs = [np.ascontiguousarray(part, dtype=float) for part in rows]
    n, numbers = len(inputs[0]), range(function.n_out())
    given = [(len(part), part.size) for part in inputs]
    wanted = [(n, n * function.nnz_in(k)) for k in range(function.n_in())]
    assert given == wanted, f"{function.name()} takes {wanted} numbers, {given} were given"
    assert all(function.sparsity_out(k).is_dense() for k in numbers), f"{function.name()} has sparse outputs"
    shapes = [(function.size2_out(k), function.size1_out(k)) for k in numbers]
    results = [np.empty((n, *shape)) for shape in shapes]  # matrices of CasADi lie in memory column by column
    for begin in range(0, n, SAMPLES):
        length = min(SAMPLES, n - begin)
        some = slice(begin, begin + length)
        buffer, run = (function if length == 1 else _mapped(function, length)).buffer()
        for k, values in enumerate(inputs):
            buffer.set_arg(k, values[some].data)
        for k, result in enumerate(results):
            buffer.set_res(k, result[some].data)
        run()
    return tuple(
        part[:, 0] if columns == 1 else part.transpose(0, 2, 1)
        for part, (columns, _) in zip(results, shapes, strict=True)
    )


@lru_cache(maxsize=32)
def _mapped(function: ca.Function, n: int) -> ca.Function:
    """Return a function of n samples side by side; many records of one length ask for the same one."""
    return function.map(n)
