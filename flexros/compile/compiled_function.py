"""A CasADi function as machine code, called with NumPy arrays."""

from __future__ import annotations

import ctypes
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.compile.module_builder import ModuleBuilder
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import casadi as ca

    from flexros.arrays import FloatArray, IntArray
    from flexros.compile.machine_code import MachineCode


class CompiledFunction:
    """Machine code of one function; thread-safe, keeps its code alive.

    With one lane, arrays are the matrices of the CasADi function, shape (rows,) for columns and (rows, columns) else.
    With L lanes, arrays are (elements, L): column-major elements, lanes adjacent in memory.
    """

    def __init__(self, function: ca.Function, symbol: str, lanes: int, code: MachineCode) -> None:
        """Wrap a function of a module.

        Args:
            function: The CasADi function (shapes and names are taken from it).
            symbol: Its symbol in the module, which also has the entry `<symbol>.packed`.
            lanes: Doubles per number.
            code: The module.
        """
        self.name = function.name()
        self.lanes = lanes
        self.address = code.address(symbol)
        """Address of `void f(const double* in0, ..., double* out0, ...)`."""
        self.input_names = tuple(function.name_in())
        self.output_names = tuple(function.name_out())
        self.input_shapes = tuple(_shape(function.size_in(k), lanes) for k in range(function.n_in()))
        self.output_shapes = tuple(_shape(function.size_out(k), lanes) for k in range(function.n_out()))
        self._code = code
        packed = code.address(f"{symbol}.packed")
        self._call = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(packed)
        self._call_with_gil = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)(packed)

    @property
    def n_in(self) -> int:
        """Number of inputs."""
        return len(self.input_shapes)

    @property
    def n_out(self) -> int:
        """Number of outputs."""
        return len(self.output_shapes)

    def __call__(self, *inputs: FloatArray) -> tuple[FloatArray, ...]:
        """Evaluate the function with the GIL released.

        Args:
            inputs: One array per input, shapes `input_shapes`.

        Returns:
            One new array per output, shapes `output_shapes`.

        Raises:
            InputError: Wrong number or shape of inputs.
        """
        if len(inputs) != self.n_in:
            raise InputError(f"{self.name} takes {self.n_in} inputs {list(self.input_names)}, {len(inputs)} were given")
        arrays = [self._input(k, value) for k, value in enumerate(inputs)]
        order: str = "F" if self.lanes == 1 else "C"
        results = tuple(np.empty(shape, order=order) for shape in self.output_shapes)  # type: ignore[call-overload]
        pointers = np.array([a.ctypes.data for a in (*arrays, *results)], dtype=np.uint64)
        self._call(pointers.ctypes.data)
        return results

    def bind(self, *arrays: FloatArray) -> Callable[[], None]:
        """Prepare a call without arguments on fixed arrays, for use at every sample (overhead 0.2 us).

        The call reads the inputs, writes the outputs and holds the GIL: it is for functions that take microseconds.

        Args:
            arrays: All inputs, then all outputs: float64, exact shape, contiguous (column-major with one lane),
                outputs writeable and apart from the inputs.

        Raises:
            InputError: An array that would have to be copied.
        """
        shapes = self.input_shapes + self.output_shapes
        names = self.input_names + self.output_names
        if len(arrays) != len(shapes):
            raise InputError(f"{self.name} binds {len(shapes)} arrays {list(names)}, {len(arrays)} were given")
        for k, (array, shape) in enumerate(zip(arrays, shapes, strict=True)):
            flags = array.flags
            contiguous = flags.f_contiguous if self.lanes == 1 else flags.c_contiguous
            writeable = flags.writeable or k < self.n_in
            if array.dtype != np.float64 or array.shape != shape or not contiguous or not writeable:
                raise InputError(
                    f"{self.name}: array '{names[k]}' has shape {array.shape} and type {array.dtype}, needed is a "
                    f"contiguous{'' if k < self.n_in else ', writeable'} float64 array of shape {shape}"
                )
        bound = bind_packed(self._call_with_gil, arrays)
        bound.owners += (self,)
        return bound

    def _input(self, k: int, value: FloatArray) -> FloatArray:
        array = np.asarray(value, dtype=np.float64, order="F" if self.lanes == 1 else "C")
        if array.shape != self.input_shapes[k]:
            raise InputError(
                f"{self.name}: input '{self.input_names[k]}' has shape {array.shape}, needed is {self.input_shapes[k]}"
            )
        return array


def bind_packed(call: Callable[[int], object], arrays: Sequence[FloatArray | IntArray]) -> _BoundCall:
    """Fix the pointers of a function that takes them as one array; the result keeps the arrays alive.

    Args:
        call: Entry made by `packed_entry`, as a ctypes function.
        arrays: The arrays in order of the pointers.
    """
    pointers = np.array([a.ctypes.data for a in arrays], dtype=np.uint64)
    bound = _BoundCall(call, ctypes.c_void_p(pointers.ctypes.data))
    bound.owners = (pointers, tuple(arrays))
    return bound


class _BoundCall(partial):  # type: ignore[type-arg]
    """A call with its pointers and the objects that own their memory."""

    owners: tuple[object, ...]


def compile_function(function: ca.Function, *, lanes: int = 1) -> CompiledFunction:
    """Compile a CasADi function to machine code.

    Args:
        function: Function of SX (MX functions are expanded), dense inputs.
        lanes: Doubles per number: 1, or 2, 4, 8, 16 parallel evaluations with equal results.

    Raises:
        InputError: Unknown operation, free variables, sparse inputs or an unusable number of lanes.
    """
    builder = ModuleBuilder()
    symbol = builder.add_function(function, lanes=lanes)
    builder.add_text(packed_entry(symbol, function.n_in() + function.n_out()))
    return CompiledFunction(function, symbol, lanes, builder.build())


def packed_entry(symbol: str, n_pointers: int) -> str:
    """Return the text of `void <symbol>.packed(ptr)`, which takes all pointers as one array.

    Args:
        symbol: Function that takes `n_pointers` pointers and returns nothing.
        n_pointers: Their number.
    """
    lines = [f"define void @{symbol}.packed(ptr %pointers) nounwind {{"]
    for k in range(n_pointers):
        lines.append(f"  %a{k} = getelementptr ptr, ptr %pointers, i64 {k}\n  %p{k} = load ptr, ptr %a{k}")
    arguments = ", ".join(f"ptr %p{k}" for k in range(n_pointers))
    return "\n".join([*lines, f"  call void @{symbol}({arguments})", "  ret void", "}"])


def _shape(size: tuple[int, int], lanes: int) -> tuple[int, ...]:
    if lanes > 1:
        return (size[0] * size[1], lanes)
    return (size[0],) if size[1] == 1 else size
