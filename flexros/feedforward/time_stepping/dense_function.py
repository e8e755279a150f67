"""Functions with dense values."""

from __future__ import annotations

import casadi as ca


def dense_function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
    """Return a dense function with common subexpressions eliminated."""
    return ca.Function(name, inputs, [ca.densify(ca.SX(value)) for value in outputs], {"cse": True})
