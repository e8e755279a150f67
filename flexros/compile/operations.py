"""Tables of the CasADi operations and their LLVM code.

Semantics are those of CasADi's virtual machine, with two choices: the minimum and maximum of a number and NaN is NaN
(a diverged simulation must stay visible behind a limiter), and sine, cosine, exp, log and tanh come from
`elementary.py`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.elementary import EXPONENTIAL, LOGARITHM, SINCOS, TANH, library_call

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.compile.ir_text import IrBlock

ROUTINES: dict[int, tuple[str, int | None]] = {
    ca.OP_SIN: (SINCOS, 0),
    ca.OP_COS: (SINCOS, 1),
    ca.OP_EXP: (EXPONENTIAL, None),
    ca.OP_LOG: (LOGARITHM, None),
    ca.OP_TANH: (TANH, None),
}
"""Operations by routines of `elementary.py`: routine, and member of its result (None: the result itself)."""

COMPARISONS: dict[int, str] = {ca.OP_LT: "olt", ca.OP_LE: "ole", ca.OP_EQ: "oeq", ca.OP_NE: "une"}
"""Comparisons as LLVM conditions; their value as a number is 1 or 0."""

LIBRARY: dict[int, str] = {
    ca.OP_LOG1P: "log1p", ca.OP_EXPM1: "expm1", ca.OP_POW: "pow", ca.OP_CONSTPOW: "pow",
    ca.OP_TAN: "tan", ca.OP_ASIN: "asin", ca.OP_ACOS: "acos", ca.OP_ATAN: "atan", ca.OP_ATAN2: "atan2",
    ca.OP_SINH: "sinh", ca.OP_COSH: "cosh", ca.OP_ASINH: "asinh", ca.OP_ACOSH: "acosh", ca.OP_ATANH: "atanh",
    ca.OP_ERF: "erf", ca.OP_FMOD: "fmod", ca.OP_REMAINDER: "remainder", ca.OP_HYPOT: "hypot",
}  # fmt: skip
"""Operations by the system's mathematical library, lane by lane."""

LIBRARY_SYMBOLS: frozenset[str] = frozenset(LIBRARY.values()) | {"sin", "cos", "fma"}


def _choose_extreme(condition: str) -> Callable[[IrBlock, str, str], str]:
    def write(block: IrBlock, a: str, b: str) -> str:
        extreme = block.select(block.compare(condition, a, b), a, b)
        return block.select(block.compare("uno", a, a), a, extreme)

    return write


def _sign(block: IrBlock, a: str, _: str) -> str:
    zero = block.number(0.0)
    positive = block.select(block.compare("ogt", a, zero), block.number(1.0), a)
    return block.select(block.compare("olt", a, zero), block.number(-1.0), positive)


ARITHMETIC: dict[int, Callable[[IrBlock, str, str], str]] = {
    ca.OP_ADD: lambda block, a, b: block.add(a, b),
    ca.OP_SUB: lambda block, a, b: block.sub(a, b),
    ca.OP_MUL: lambda block, a, b: block.mul(a, b),
    ca.OP_DIV: lambda block, a, b: block.div(a, b),
    ca.OP_NEG: lambda block, a, _: block.value(f"fneg {block.type} {a}"),
    ca.OP_SQ: lambda block, a, _: block.mul(a, a),
    ca.OP_TWICE: lambda block, a, _: block.add(a, a),
    ca.OP_INV: lambda block, a, _: block.div(block.number(1.0), a),
    ca.OP_SQRT: lambda block, a, _: block.intrinsic("sqrt", a),
    ca.OP_FABS: lambda block, a, _: block.intrinsic("fabs", a),
    ca.OP_FLOOR: lambda block, a, _: block.intrinsic("floor", a),
    ca.OP_CEIL: lambda block, a, _: block.intrinsic("ceil", a),
    ca.OP_COPYSIGN: lambda block, a, b: block.intrinsic("copysign", a, b),
    ca.OP_SIGN: _sign,
    ca.OP_FMIN: _choose_extreme("olt"),
    ca.OP_FMAX: _choose_extreme("ogt"),
}
"""Operations of one or two numbers that need a few instructions."""

LOGIC = frozenset({ca.OP_NOT, ca.OP_AND, ca.OP_OR})
"""Operations on truth values; their value as a number is 1 or 0."""


def write_number(block: IrBlock, operation: int, a: str, b: str) -> str:
    """Write an operation of ARITHMETIC or LIBRARY and return the name of its value.

    Args:
        block: Where to write.
        operation: CasADi operation code.
        a: First operand.
        b: Second operand; ignored by operations of one operand.
    """
    if operation in ARITHMETIC:
        return ARITHMETIC[operation](block, a, b)
    return library_call(block, LIBRARY[operation], *((a, b) if b else (a,)))


def is_known(operation: int) -> bool:
    """Return whether an operation can be compiled."""
    tables = (ARITHMETIC, LIBRARY, COMPARISONS, ROUTINES, LOGIC)
    return operation == ca.OP_IF_ELSE_ZERO or any(operation in table for table in tables)
