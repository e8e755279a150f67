"""Dense linear systems inside compiled code: LU factorisation with partial pivoting.

The factors are kept in columns padded to whole vectors, with zeros in place of the other factor, so that every loop
runs over full vectors (right-looking elimination with deferred row exchanges as in LINPACK's dgefa; Golub and Van Loan
2013, algorithm 3.4.1). Systems of up to seven unknowns have an unrolled form in which a row is one vector.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.compile.ir_text import IrBlock
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.compile.module_builder import ModuleBuilder

WIDTH = 8
UNROLLED_SIZE = 7
_NUMBERS = f"<{WIDTH} x double>"
_COLUMNS_TOGETHER = 4


@dataclass(frozen=True)
class LuRoutines:
    """Symbols of the routines for one size; all matrices are n x n doubles, right-hand sides (n, columns) column-major.

    Attributes:
        factor: `i64 @factor(ptr matrix, ptr work)`: fills the workspace; returns 0, or k + 1 if pivot k is 0 or not
            finite.
        solve: `void @solve(ptr work, ptr rhs, i64 columns)`: replaces the right-hand sides by the solutions.
        factor_solve: `i64 @factor_solve(ptr matrix, ptr rhs)`: both for one right-hand side; the status of `factor`.
        work_size: Length of the workspace [doubles]; an alignment of 8 bytes is sufficient, 64 is fastest.
    """

    factor: str
    solve: str
    factor_solve: str
    work_size: int


@dataclass(frozen=True)
class _Layout:
    """Workspace: L (n columns), U (n columns), inverse diagonal of U, rows exchanged with."""

    n: int

    @property
    def stride(self) -> int:
        return -(-self.n // WIDTH) * WIDTH

    @property
    def upper(self) -> int:
        return self.stride * self.n

    @property
    def diagonal(self) -> int:
        return 2 * self.stride * self.n

    @property
    def pivots(self) -> int:
        return self.diagonal + self.stride

    @property
    def size(self) -> int:
        return self.pivots + self.stride


def add_lu_solver(builder: ModuleBuilder, n: int, *, row_major: bool = False) -> LuRoutines:
    """Add the routines for systems of n unknowns to a module, unless it has them.

    Args:
        builder: The module.
        n: Number of unknowns.
        row_major: Order of the matrices; False is the order of CasADi.

    Raises:
        InputError: n is not positive.
    """
    if n < 1:
        raise InputError(f"a linear system needs at least 1 unknown, n = {n} was given")
    stem = f"lu{n}.{'row' if row_major else 'column'}"
    layout = _Layout(n)
    routines = LuRoutines(f"{stem}.factor", f"{stem}.solve", f"{stem}.factor_solve", layout.size)
    if routines.factor not in builder:
        builder.add_text(_factor_text(routines.factor, layout, row_major), routines.factor)
        builder.add_text(_solve_text(routines.solve, layout), routines.solve)
        whole = _unrolled_text(routines, n, row_major) if n <= UNROLLED_SIZE else _combined_text(routines, layout)
        builder.add_text(whole, routines.factor_solve)
    return routines


def _column(block: IrBlock, index: str, layout: _Layout, offset: int) -> str:
    start = block.value(f"mul nsw i64 {index}, {layout.stride}")
    return block.pointer("%work", block.value(f"add nsw i64 {start}, {offset}"), "double")


def _load(block: IrBlock, base: str, row: str | int) -> str:
    return block.value(f"load {_NUMBERS}, ptr {block.pointer(base, row, 'double')}, align 8")


def _store(block: IrBlock, numbers: str, base: str, row: str | int) -> None:
    block.emit(f"store {_NUMBERS} {numbers}, ptr {block.pointer(base, row, 'double')}, align 8")


def _subtract_multiple(block: IrBlock, target: str, row: str, factor: str, column: str) -> None:
    """target[row:row+WIDTH] -= factor * column, all vectors."""
    product = block.value(f"fmul {_NUMBERS} {factor}, {column}")
    _store(block, block.value(f"fsub {_NUMBERS} {_load(block, target, row)}, {product}"), target, row)


def _copy_matrix(block: IrBlock, layout: _Layout, row_major: bool) -> None:
    """Copy the matrix into the columns of U; padding rows are zero."""
    n = layout.n
    with block.loop(0, n) as j:
        column = _column(block, j.index, layout, layout.upper)
        if layout.stride > n:
            _store(block, "zeroinitializer", column, layout.stride - WIDTH)
        with block.loop(0, n) as i:
            a, b = (i.index, j.index) if row_major else (j.index, i.index)
            element = block.value(f"add nsw i64 {block.value(f'mul nsw i64 {a}, {n}')}, {b}")
            block.store(block.load("%matrix", element), column, i.index)


def _find_pivot(block: IrBlock, column: str, k: str, n: int) -> tuple[str, str]:
    """Return the row of the largest magnitude from row k on, and that element's magnitude."""
    first = block.intrinsic("fabs", block.load(column, k))
    with block.loop(block.value(f"add nsw i64 {k}, 1"), n, carry=[("i64", k), ("double", first)]) as i:
        magnitude = block.intrinsic("fabs", block.load(column, i.index))
        larger = block.compare("ogt", magnitude, i.values[1])
        row = block.value(f"select i1 {larger}, i64 {i.index}, i64 {i.values[0]}")
        i.next_values = [row, block.select(larger, magnitude, i.values[1])]
    return i.values[0], i.values[1]


def _factor_text(symbol: str, layout: _Layout, row_major: bool) -> str:
    block = IrBlock()
    _copy_matrix(block, layout, row_major)
    diagonal = block.pointer("%work", layout.diagonal)
    pivots = block.pointer("%work", layout.pivots)
    with block.loop(0, layout.n, carry=[("i64", "0")]) as k:
        column = _column(block, k.index, layout, layout.upper)
        lower = _column(block, k.index, layout, 0)
        row, magnitude = _find_pivot(block, column, k.index, layout.n)
        after = block.value(f"add nsw i64 {k.index}, 1")
        finite = block.compare("ord", block.sub(magnitude, magnitude), block.number(0.0))
        usable = block.value(f"and i1 {finite}, {block.compare('ogt', magnitude, block.number(0.0))}")
        fresh = block.value(f"icmp eq i64 {k.values[0]}, 0")
        failed = block.value(f"select i1 {usable}, i64 0, i64 {after}")
        k.next_values = [block.value(f"select i1 {fresh}, i64 {failed}, i64 {k.values[0]}")]
        block.emit(f"store i64 {row}, ptr {block.pointer(pivots, k.index)}, align 8")
        pivot = block.load(column, row)
        inverse = block.div(block.number(1.0), pivot)
        block.store(inverse, diagonal, k.index)
        block.store(block.load(column, k.index), column, row)
        _split_column(block, column, lower, k.index, inverse, layout)
        _eliminate(block, lower, k.index, row, layout)
    block.emit(f"ret i64 {k.values[0]}")
    return f"define i64 @{symbol}(ptr noalias %matrix, ptr noalias %work) nounwind {{\n{block.text()}\n}}"


def _split_column(block: IrBlock, column: str, lower: str, k: str, inverse: str, layout: _Layout) -> None:
    """Move the multipliers below row k to L and clear them, and the diagonal element, in U."""
    vectors = block.of_lanes(WIDTH)
    factor, row_k = vectors.splat(inverse), vectors.splat_integer(k)
    lanes = ", ".join(f"i64 {lane}" for lane in range(WIDTH))
    with block.loop(0, layout.stride, WIDTH) as i:
        rows = vectors.value(f"add {vectors.integer} {vectors.splat_integer(i.index)}, <{lanes}>")
        numbers = _load(block, column, i.index)
        scaled = block.value(f"fmul {_NUMBERS} {numbers}, {factor}")
        below = vectors.value(f"icmp sgt {vectors.integer} {rows}, {row_k}")
        above = vectors.value(f"icmp slt {vectors.integer} {rows}, {row_k}")
        for choice, number, target in ((below, scaled, lower), (above, numbers, column)):
            kept = vectors.select(choice, number, "zeroinitializer")
            _store(block, kept, target, i.index)


def _eliminate(block: IrBlock, lower: str, k: str, row: str, layout: _Layout) -> None:
    """Exchange rows k and `row`, and subtract multiples of column k of L from the columns to its right."""
    first = block.value(f"add nsw i64 {k}, 1")
    start = block.value(f"and i64 {first}, {-WIDTH}")
    count = block.value(f"sub nsw i64 {layout.n}, {first}")
    whole = block.value(f"add nsw i64 {first}, {block.value(f'and i64 {count}, {-_COLUMNS_TOGETHER}')}")
    # several columns per pass: each vector of L is loaded once for all of them
    for begin, end, together in ((first, whole, _COLUMNS_TOGETHER), (whole, str(layout.n), 1)):
        with block.loop(begin, end, together) as j:
            columns, factors = [], []
            for offset in range(together):
                index = block.value(f"add nsw i64 {j.index}, {offset}")
                column = _column(block, index, layout, layout.upper)
                pivot_element = block.load(column, row)
                block.store(block.load(column, k), column, row)
                block.store(pivot_element, column, k)
                columns.append(column)
                factors.append(block.of_lanes(WIDTH).splat(pivot_element))
            with block.loop(start, layout.stride, WIDTH) as i:
                numbers = _load(block, lower, i.index)
                for column, factor in zip(columns, factors, strict=True):
                    _subtract_multiple(block, column, i.index, factor, numbers)


def _solve_text(symbol: str, layout: _Layout) -> str:
    block = IrBlock()
    n = layout.n
    x = block.value(f"alloca double, i64 {layout.stride}, align 64")
    _store(block, "zeroinitializer", x, layout.stride - WIDTH)
    diagonal = block.pointer("%work", layout.diagonal)
    pivots = block.pointer("%work", layout.pivots)
    with block.loop(0, "%columns") as c:
        rhs = block.pointer("%rhs", block.value(f"mul nsw i64 {c.index}, {n}"))
        with block.loop(0, n) as i:
            block.store(block.load(rhs, i.index), x, i.index)
        # forward substitution with the row exchanges of the factorisation, one column of L at a time
        with block.loop(0, n) as k:
            row = block.value(f"load i64, ptr {block.pointer(pivots, k.index)}, align 8")
            number = block.load(x, row)
            block.store(block.load(x, k.index), x, row)
            block.store(number, x, k.index)
            factor, lower = block.of_lanes(WIDTH).splat(number), _column(block, k.index, layout, 0)
            first = block.value(f"and i64 {block.value(f'add nsw i64 {k.index}, 1')}, {-WIDTH}")
            with block.loop(first, layout.stride, WIDTH) as i:
                _subtract_multiple(block, x, i.index, factor, _load(block, lower, i.index))
        # back substitution from the last unknown, one column of U at a time
        with block.loop(0, n) as back:
            k_index = block.value(f"sub nsw i64 {n - 1}, {back.index}")
            number = block.mul(block.load(x, k_index), block.load(diagonal, k_index))
            block.store(number, rhs, k_index)
            factor, upper = block.of_lanes(WIDTH).splat(number), _column(block, k_index, layout, layout.upper)
            with block.loop(0, k_index, WIDTH) as i:
                _subtract_multiple(block, x, i.index, factor, _load(block, upper, i.index))
    block.emit("ret void")
    return f"define void @{symbol}(ptr noalias %work, ptr noalias %rhs, i64 %columns) nounwind {{\n{block.text()}\n}}"


def _combined_text(routines: LuRoutines, layout: _Layout) -> str:
    return f"""define i64 @{routines.factor_solve}(ptr noalias %matrix, ptr noalias %rhs) nounwind {{
  %work = alloca double, i64 {layout.size}, align 64
  %status = call i64 @{routines.factor}(ptr %matrix, ptr %work)
  call void @{routines.solve}(ptr %work, ptr %rhs, i64 1)
  ret i64 %status
}}"""


def _unrolled_text(routines: LuRoutines, n: int, row_major: bool) -> str:
    """Write Gaussian elimination in registers: row i of [matrix, rhs] is one vector, exchanges are selections.

    Each row below k is compared with row k and exchanged with it if its pivot is larger, which leaves the largest in
    row k without an index that is known at run time only.
    """
    block = IrBlock()
    rows = []
    for i in range(n):
        row = "undef"
        for j in range(n):
            element = block.load("%matrix", i * n + j if row_major else j * n + i)
            row = block.value(f"insertelement {_NUMBERS} {row}, double {element}, i32 {j}")
        rows.append(block.value(f"insertelement {_NUMBERS} {row}, double {block.load('%rhs', i)}, i32 {n}"))
    status = "0"
    for k in range(n):
        for i in range(k + 1, n):
            a, b = (block.value(f"extractelement {_NUMBERS} {rows[r]}, i32 {k}") for r in (i, k))
            larger = block.compare("ogt", block.intrinsic("fabs", a), block.intrinsic("fabs", b))
            upper = block.value(f"select i1 {larger}, {_NUMBERS} {rows[i]}, {_NUMBERS} {rows[k]}")
            rows[i] = block.value(f"select i1 {larger}, {_NUMBERS} {rows[k]}, {_NUMBERS} {rows[i]}")
            rows[k] = upper
        pivot = block.value(f"extractelement {_NUMBERS} {rows[k]}, i32 {k}")
        inverse = block.div(block.number(1.0), pivot)
        magnitude = block.intrinsic("fabs", inverse)
        usable = block.value(f"and i1 {block.compare('olt', magnitude, block.number(float('inf')))}, "
                             f"{block.compare('ogt', magnitude, block.number(0.0))}")  # fmt: skip
        failed = block.value(f"select i1 {usable}, i64 0, i64 {k + 1}")
        fresh = block.value(f"icmp eq i64 {status}, 0")
        status = block.value(f"select i1 {fresh}, i64 {failed}, i64 {status}")
        rows[k] = block.value(f"fmul {_NUMBERS} {rows[k]}, {block.of_lanes(WIDTH).splat(inverse)}")
        for i in range(k + 1, n):
            factor = block.of_lanes(WIDTH).splat(block.value(f"extractelement {_NUMBERS} {rows[i]}, i32 {k}"))
            product = block.value(f"fmul {_NUMBERS} {factor}, {rows[k]}")
            rows[i] = block.value(f"fsub {_NUMBERS} {rows[i]}, {product}")
    _back_substitute(block, rows, n)
    block.emit(f"ret i64 {status}")
    return f"define i64 @{routines.factor_solve}(ptr %matrix, ptr %rhs) nounwind {{\n{block.text()}\n}}"


def _back_substitute(block: IrBlock, rows: list[str], n: int) -> None:
    numbers: dict[int, str] = {}
    for i in reversed(range(n)):
        total = block.value(f"extractelement {_NUMBERS} {rows[i]}, i32 {n}")
        for j in range(n - 1, i, -1):
            element = block.value(f"extractelement {_NUMBERS} {rows[i]}, i32 {j}")
            total = block.sub(total, block.mul(element, numbers[j]))
        numbers[i] = total
        block.store(total, "%rhs", i)
