"""Builds one machine-code module from SX functions and hand-written drivers.

A driver is LLVM text that calls the functions directly, so a loop over thousands of samples never returns to Python:

    builder = ModuleBuilder()
    f = builder.add_function(residual)              # casadi.Function -> symbol, here "residual"
    solve = add_lu_solver(builder, n=5)             # linear_solver.py: symbol of a dense LU solver
    builder.add_text(f'''
    define i64 @run(i64 %n, ptr noalias %x, ptr noalias %out) {{
      ...
      call void @{f}(ptr %x, ptr %scratch)
      %ok = call i64 @{solve}(ptr %matrix, ptr %rhs)
      ...
    }}''')
    code = builder.build()                          # MachineCode: keeps the engine alive
    run = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)(code.address("run"))

Conventions. `void @f(ptr in0, ..., ptr out0, ...)`: one pointer per input and per output, doubles column-major, dense,
no output overlapping an input. With `lanes` = L every number is L adjacent doubles (`<L x double>`), arrays are
(elements, L). Pointers need the alignment of a double only; text of drivers therefore writes `align 8` on vector
accesses to arrays of callers. Calls through ctypes.CFUNCTYPE release the GIL; all scratch memory is on the stack, so
everything is reentrant. LLVM intrinsics (`@llvm.sqrt.f64`) and the mathematical library (`@atan2`) may be called
without declaring them, as may `@llvm.memcpy.p0.p0.i64` and `@llvm.memset.p0.i64`. `IrBlock` of ir_text.py writes
arithmetic and loops without counting value names by hand.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from threading import Lock
from typing import TYPE_CHECKING

from flexros.compile.elementary import routine_text
from flexros.compile.ir_text import LANE_COUNTS
from flexros.compile.machine_code import MachineCode
from flexros.compile.nested_calls import is_long, nested_calls
from flexros.compile.object_cache import fingerprint
from flexros.compile.operations import LIBRARY_SYMBOLS
from flexros.compile.sx_emitter import emit_function
from flexros.compile.sx_graph import dense_sx_function, read_graph
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    import casadi as ca

    from flexros.compile.nested_calls import NestedCalls

_INTRINSIC = re.compile(r"@llvm\.(sqrt|fabs|floor|ceil|copysign|fma)\.(f64|v\d+f64)\b")
_LIBRARY_CALL = re.compile(r"call double @(\w+)\(")
_MEMORY = {
    "@llvm.memcpy.p0.p0.i64": "declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1 immarg)",
    "@llvm.memmove.p0.p0.i64": "declare void @llvm.memmove.p0.p0.i64(ptr, ptr, i64, i1 immarg)",
    "@llvm.memset.p0.i64": "declare void @llvm.memset.p0.i64(ptr, i8, i64, i1 immarg)",
}
_TWO_OPERANDS = frozenset({"pow", "atan2", "fmod", "remainder", "hypot"})
_SYMBOL = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*")


class ModuleBuilder:
    """Collects functions and drivers, then compiles them together."""

    def __init__(self) -> None:
        """Start an empty module."""
        self._texts: dict[str, str] = {}
        self._routines: set[tuple[str, int]] = set()
        self._shared: dict[str, _SharedFunction] = {}

    def __contains__(self, symbol: object) -> bool:
        """Return whether a symbol was added."""
        return symbol in self._texts

    def add_function(self, function: ca.Function, *, name: str | None = None, lanes: int = 1) -> str:
        """Add a CasADi function.

        Args:
            function: Function of SX, dense inputs. MX functions are expanded, but long functions that one of them calls
                are compiled on their own, once for all modules.
            name: Symbol to define; the function's own name when None.
            lanes: Doubles per number, one of 1, 2, 4, 8, 16.

        Returns:
            The symbol, to be called as `void @symbol(ptr in0, ..., ptr out0, ...)`.

        Raises:
            InputError: Unknown operation, free variables, sparse inputs or an unusable number of lanes.
        """
        check_lanes(lanes)
        nested = nested_calls(function)
        if nested is not None and any(is_long(call.function) for call in nested.calls):
            return self._add_nested(nested, name or function.name(), lanes)
        function = dense_sx_function(function)
        symbol = self._free_symbol(name or function.name())
        emitted = emit_function(read_graph(function), symbol, lanes)
        self._routines |= emitted.routines
        self._texts[symbol] = emitted.text
        return symbol

    def add_text(self, text: str, symbol: str | None = None) -> None:
        """Add hand-written LLVM text: drivers, constants, routines.

        Args:
            text: Definitions.
            symbol: Name under which the text is kept, so that a routine is added once (`symbol in builder`).
        """
        self._texts[self._free_symbol(symbol) if symbol else f".text{len(self._texts)}"] = text

    def build(self, *, level: int = 1) -> MachineCode:
        """Compile everything.

        Args:
            level: Optimisation level of the code generator, 0 to 3.
        """
        return _compiled((self.text(), *(shared.module for _, shared in sorted(self._shared.items()))), level)

    def text(self) -> str:
        """Return the module as LLVM text."""
        declared = [shared.declaration for _, shared in sorted(self._shared.items())]
        return _module_text(self._routines, [*declared, *self._texts.values()])

    def _add_nested(self, nested: NestedCalls, name: str, lanes: int) -> str:
        """Add a function that only calls others, and what it calls."""
        called = []
        for number, call in enumerate(nested.calls):
            if is_long(call.function):
                shared = _shared_function(call.function, lanes)
                self._shared[shared.symbol] = shared
                called.append(shared.symbol)
            else:
                called.append(self.add_function(call.function, name=f"{name}.call{number}", lanes=lanes))
        symbol = self._free_symbol(name)
        self.add_text(nested.text(symbol, called, lanes), symbol)
        return symbol

    def _free_symbol(self, symbol: str) -> str:
        if not _SYMBOL.fullmatch(symbol):
            raise InputError(f"'{symbol}' cannot name a compiled function: use letters, digits, underscores and dots")
        if symbol in self._texts:
            raise InputError(f"the module already has a function '{symbol}': choose another name")
        return symbol


@dataclass(frozen=True)
class _SharedFunction:
    """A long function in a module of its own.

    Attributes:
        function: The function.
        symbol: Its name, which no other function has.
        declaration: Declaration for the modules that call it.
        module: Text of its own module.
    """

    function: ca.Function
    symbol: str
    declaration: str
    module: str


_KEPT: dict[tuple[int, int], _SharedFunction] = {}
"""Shared functions by CasADi's own number of them, which is not given again while they are kept, and by lanes."""
_KEEPING = Lock()
_MOST_KEPT = 64
"""Most shared functions that are kept (chosen)."""


def _shared_function(function: ca.Function, lanes: int) -> _SharedFunction:
    """Write the module of a long function, once."""
    key = hash(function), lanes
    with _KEEPING:
        kept = _KEPT.get(key)
    if kept is not None:
        return kept
    graph = read_graph(dense_sx_function(function))
    content = fingerprint(*map(str, (graph.operations, graph.first, graph.second, graph.constants, graph.outputs)))
    symbol = f"{function.name()}.{content[:24]}.{lanes}"
    emitted = emit_function(graph, symbol, lanes)
    pointers = ", ".join(["ptr"] * (function.n_in() + function.n_out()))
    declaration = f"declare void @{symbol}({pointers}) nounwind"
    made = _SharedFunction(function, symbol, declaration, _module_text(emitted.routines, [emitted.text]))
    with _KEEPING:
        while len(_KEPT) >= _MOST_KEPT:
            _KEPT.pop(next(iter(_KEPT)))
        return _KEPT.setdefault(key, made)


def _module_text(routines: Collection[tuple[str, int]], texts: Sequence[str]) -> str:
    """Write a module with the routines and declarations that its texts need."""
    body = [*(routine_text(*key) for key in sorted(routines)), *texts]
    return "\n".join([*_declarations("\n".join(body)), *body])


@lru_cache(maxsize=64)
def _compiled(texts: tuple[str, ...], level: int) -> MachineCode:
    """Compile modules once; many logs of one robot use the same ones."""
    return MachineCode(texts, level)


def check_lanes(lanes: int) -> None:
    """Refuse a number of lanes that has no vector type.

    Raises:
        InputError: `lanes` is not one of LANE_COUNTS.
    """
    if lanes not in LANE_COUNTS:
        raise InputError(f"lanes = {lanes} is not possible: allowed are {', '.join(map(str, LANE_COUNTS))}")


def _declarations(text: str) -> list[str]:
    """Declare the intrinsics and library functions that a text calls."""
    lines = []
    for name, suffix in sorted(set(_INTRINSIC.findall(text))):
        number = "double" if suffix == "f64" else f"<{suffix[1:-3]} x double>"
        operands = {"copysign": 2, "fma": 3}.get(name, 1)
        lines.append(f"declare {number} @llvm.{name}.{suffix}({', '.join([number] * operands)})")
    lines += [line for symbol, line in _MEMORY.items() if symbol in text]
    for name in sorted(set(_LIBRARY_CALL.findall(text)) & LIBRARY_SYMBOLS):
        operands = 2 if name in _TWO_OPERANDS else 1
        lines.append(f"declare double @{name}({', '.join(['double'] * operands)}) nounwind")
    return lines
