"""Text of LLVM intermediate representation: literals, vector types, blocks of instructions, element-wise loops.

The compiler emits text instead of objects of a builder library: a line costs a microsecond, and LLVM parses 20,000
lines in 20 ms. Every arithmetic instruction is written without fast-math flags, so that the order of operations is that
of IEEE 754 and results are equal in every lane.
"""

from __future__ import annotations

import struct
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

LANE_COUNTS: tuple[int, ...] = (1, 2, 4, 8, 16)
CHUNK = 8  # doubles per vector
_UNROLLED_CHUNKS = 8


def value_type(lanes: int) -> str:
    """Return the LLVM type of one number: `double`, or `<lanes x double>`."""
    return "double" if lanes == 1 else f"<{lanes} x double>"


def integer_type(lanes: int) -> str:
    """Return the LLVM type of 64 integer bits per lane."""
    return "i64" if lanes == 1 else f"<{lanes} x i64>"


def mask_type(lanes: int) -> str:
    """Return the LLVM type of one truth value per lane."""
    return "i1" if lanes == 1 else f"<{lanes} x i1>"


def alignment(lanes: int) -> int:
    """Return the alignment [byte] of numbers in local memory (arrays of the caller are aligned to 8)."""
    return min(8 * lanes, 64)


def float_literal(value: float, lanes: int = 1) -> str:
    """Return the exact literal of a number, repeated for every lane."""
    bits = struct.unpack("<Q", struct.pack("<d", value))[0]
    literal = f"0x{bits:016X}"
    return literal if lanes == 1 else "<" + ", ".join([f"double {literal}"] * lanes) + ">"


def integer_literal(value: int, lanes: int = 1) -> str:
    """Return the literal of a 64-bit integer, repeated for every lane."""
    return str(value) if lanes == 1 else "<" + ", ".join([f"i64 {value}"] * lanes) + ">"


@dataclass
class IrLoop:
    """A counted loop being written.

    Attributes:
        index: Name of the i64 counter.
        values: Names of the carried values: of the present iteration inside the loop, final after it.
        next_values: Their values for the next iteration; the body sets them.
    """

    index: str
    values: list[str]
    next_values: list[str] = field(default_factory=list)


class IrBlock:
    """Instructions on numbers of `lanes` doubles; every method returns the name of the new value.

    Example:
        >>> block = IrBlock(lanes=1)
        >>> total = block.add("%a", block.mul("%b", block.number(2.0)))
        >>> block.emit(f"ret double {total}")
        >>> print(block.text())
          %t0 = fmul double %b, 0x4000000000000000
          %t1 = fadd double %a, %t0
          ret double %t1
    """

    def __init__(self, lanes: int = 1, prefix: str = "t") -> None:
        """Start an empty block whose value names begin with `prefix`."""
        self.lanes = lanes
        self.type = value_type(lanes)
        self.integer = integer_type(lanes)
        self.mask = mask_type(lanes)
        self._prefix = prefix
        self._count = 0
        self._lines: list[str] = []
        self._views: dict[int, IrBlock] = {lanes: self}

    def of_lanes(self, lanes: int) -> IrBlock:
        """Return a writer into the same block for another number of lanes."""
        if lanes not in self._views:
            view = IrBlock(lanes, f"{self._prefix}.v{lanes}.")
            view._lines, view._views = self._lines, self._views
            self._views[lanes] = view
        return self._views[lanes]

    def text(self) -> str:
        """Return the lines written so far."""
        return "\n".join(self._lines)

    def emit(self, line: str) -> None:
        """Write one instruction that has no value, or a label (ending in a colon)."""
        self._lines.append(line if line.endswith(":") else "  " + line)

    def value(self, instruction: str) -> str:
        """Write one instruction and return the name of its value."""
        name = f"%{self._prefix}{self._count}"
        self._count += 1
        self._lines.append(f"  {name} = {instruction}")
        return name

    def number(self, value: float) -> str:
        """Return the literal of a number for all lanes."""
        return float_literal(value, self.lanes)

    def add(self, a: str, b: str) -> str:
        """Write a + b."""
        return self.value(f"fadd {self.type} {a}, {b}")

    def sub(self, a: str, b: str) -> str:
        """Write a - b."""
        return self.value(f"fsub {self.type} {a}, {b}")

    def mul(self, a: str, b: str) -> str:
        """Write a * b."""
        return self.value(f"fmul {self.type} {a}, {b}")

    def div(self, a: str, b: str) -> str:
        """Write a / b."""
        return self.value(f"fdiv {self.type} {a}, {b}")

    def fma(self, a: str, b: str, c: str) -> str:
        """Write a * b + c, rounded once."""
        return self.intrinsic("fma", a, b, c)

    def polynomial(self, z: str, coefficients: Sequence[float]) -> str:
        """Write a polynomial of z by Horner's rule, the constant coefficient first."""
        total = self.number(coefficients[-1])
        for c in reversed(coefficients[:-1]):
            total = self.fma(z, total, self.number(c))
        return total

    def compare(self, condition: str, a: str, b: str) -> str:
        """Write a comparison of numbers, e.g. condition "olt"; the value is one bit per lane."""
        return self.value(f"fcmp {condition} {self.type} {a}, {b}")

    def select(self, mask: str, a: str, b: str) -> str:
        """Write the choice of a where the mask is true, else b."""
        return self.value(f"select {self.mask} {mask}, {self.type} {a}, {self.type} {b}")

    def intrinsic(self, name: str, *arguments: str) -> str:
        """Write a call of an LLVM intrinsic on numbers, e.g. `intrinsic("sqrt", x)`."""
        symbol = f"@llvm.{name}.{vector_suffix(self.lanes)}"
        return self.value(f"call {self.type} {symbol}({', '.join(f'{self.type} {a}' for a in arguments)})")

    def splat(self, number: str) -> str:
        """Write the repetition of a double in all lanes."""
        return self._splat(number, "double", self.type)

    def splat_integer(self, number: str) -> str:
        """Write the repetition of an i64 in all lanes."""
        return self._splat(number, "i64", self.integer)

    def _splat(self, scalar: str, scalar_type: str, vector_type: str) -> str:
        if self.lanes == 1:
            return scalar
        lane_0 = self.value(f"insertelement {vector_type} undef, {scalar_type} {scalar}, i32 0")
        zeros = f"<{self.lanes} x i32> zeroinitializer"
        return self.value(f"shufflevector {vector_type} {lane_0}, {vector_type} undef, {zeros}")

    def bits(self, a: str) -> str:
        """Write the reinterpretation of a number as 64 integer bits."""
        return self.value(f"bitcast {self.type} {a} to {self.integer}")

    def from_bits(self, a: str) -> str:
        """Write the reinterpretation of 64 integer bits as a number."""
        return self.value(f"bitcast {self.integer} {a} to {self.type}")

    def pointer(self, base: str, index: int | str, type_name: str = "") -> str:
        """Write the address of element `index` (a number or an i64 value) of an array of numbers."""
        return self.value(f"getelementptr {type_name or self.type}, ptr {base}, i64 {index}")

    def load(self, base: str, index: int | str = 0, align: int = 8) -> str:
        """Write the load of element `index` of an array of numbers."""
        return self.value(f"load {self.type}, ptr {self.pointer(base, index)}, align {align}")

    def store(self, number: str, base: str, index: int | str = 0, align: int = 8) -> None:
        """Write the store of element `index` of an array of numbers."""
        self.emit(f"store {self.type} {number}, ptr {self.pointer(base, index)}, align {align}")

    @contextmanager
    def loop(
        self, start: int | str, stop: int | str, step: int = 1, carry: Sequence[tuple[str, str]] = ()
    ) -> Iterator[IrLoop]:
        """Write `for (i64 index = start; index < stop; index += step)` around what the body writes.

        Args:
            start: First index, a number or an i64 value.
            stop: End of the range.
            step: Increment.
            carry: Values carried from iteration to iteration, as (type, initial value).
        """
        label = f"{self._prefix}{self._count}.loop"
        index = self._new_name()
        state = IrLoop(index, [self._new_name() for _ in carry])
        following = self._new_name()
        self.emit(f"br label %{label}.entry")
        self.emit(f"{label}.entry:")
        self.emit(f"br label %{label}.head")
        self.emit(f"{label}.head:")
        self.emit(f"{index} = phi i64 [ {start}, %{label}.entry ], [ {following}, %{label}.latch ]")
        mark = len(self._lines)
        self.emit(f"br i1 {self.value(f'icmp slt i64 {index}, {stop}')}, label %{label}.body, label %{label}.exit")
        self.emit(f"{label}.body:")
        yield state
        self.emit(f"br label %{label}.latch")
        self.emit(f"{label}.latch:")
        self.emit(f"{following} = add nsw i64 {index}, {step}")
        self.emit(f"br label %{label}.head")
        self.emit(f"{label}.exit:")
        self._lines[mark:mark] = [
            f"  {name} = phi {kind} [ {initial}, %{label}.entry ], [ {new}, %{label}.latch ]"
            for name, (kind, initial), new in zip(state.values, carry, state.next_values, strict=True)
        ]

    @contextmanager
    def when(self, condition: str) -> Iterator[None]:
        """Write a branch: the body runs only if an i1 value is true; its values are not visible afterwards."""
        label = f"{self._prefix}{self._count}.when"
        self._count += 1
        self.emit(f"br i1 {condition}, label %{label}.then, label %{label}.end")
        self.emit(f"{label}.then:")
        yield
        self.emit(f"br label %{label}.end")
        self.emit(f"{label}.end:")

    def leave_when(self, condition: str, instruction: str) -> None:
        """Write a return from the function if an i1 value is true.

        Args:
            condition: The value.
            instruction: How, e.g. "ret i64 1".
        """
        label = f"{self._prefix}{self._count}.leave"
        self._count += 1
        self.emit(f"br i1 {condition}, label %{label}.now, label %{label}.not")
        self.emit(f"{label}.now:")
        self.emit(instruction)
        self.emit(f"{label}.not:")

    def _new_name(self) -> str:
        name = f"%{self._prefix}{self._count}"
        self._count += 1
        return name


def vector_suffix(lanes: int) -> str:
    """Return the suffix of LLVM intrinsics: f64, or v8f64."""
    return "f64" if lanes == 1 else f"v{lanes}f64"


def element(block: IrBlock, base: str, position: str) -> str:
    """Write the load of one vector, with the writer's lanes, from double `position` of an array on."""
    return block.value(f"load {block.type}, ptr {block.pointer(base, position, 'double')}, align 8")


def set_element(block: IrBlock, number: str, base: str, position: str) -> None:
    """Write the store of one vector from double `position` of an array on."""
    block.emit(f"store {block.type} {number}, ptr {block.pointer(base, position, 'double')}, align 8")


def element_wise(block: IrBlock, count: int, body: Callable[[IrBlock, str], None]) -> None:
    """Write a body for all doubles of arrays, in vectors as long as possible.

    Args:
        block: Where to write.
        count: Number of doubles.
        body: Called with a writer for some lanes and the position of the first double.
    """
    whole = count - count % CHUNK
    if whole // CHUNK > _UNROLLED_CHUNKS:
        with block.loop(0, whole, CHUNK) as i:
            body(block.of_lanes(CHUNK), i.index)
    else:
        for position in range(0, whole, CHUNK):
            body(block.of_lanes(CHUNK), str(position))
    position = whole
    for width in (4, 2, 1):
        if count - position >= width:
            body(block.of_lanes(width), str(position))
            position += width
