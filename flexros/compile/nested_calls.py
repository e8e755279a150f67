"""Functions that only call others: what they call is compiled on its own, once for all that call it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.ir_text import value_type
from flexros.compile.sx_emitter import PART_LENGTH

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True)
class NestedCall:
    """One call.

    Attributes:
        function: What is called.
        inputs: Number of the value of each input.
        outputs: Number of the value of each output.
    """

    function: ca.Function
    inputs: tuple[int, ...]
    outputs: tuple[int, ...]


@dataclass(frozen=True)
class NestedCalls:
    """A function as calls in order. Values are numbered: its inputs, then what the calls return.

    Attributes:
        input_sizes: Number of elements per input.
        calls: The calls.
        results: Number of the value of each output.
        empty: Numbers of values without elements.
    """

    input_sizes: tuple[int, ...]
    calls: tuple[NestedCall, ...]
    results: tuple[int, ...]
    empty: frozenset[int]

    def text(self, symbol: str, called: Sequence[str], lanes: int) -> str:
        """Write the function as LLVM text.

        Args:
            symbol: Its name, without the @.
            called: Symbol of the function of each call.
            lanes: Doubles per number.
        """
        names = {number: f"%in{number}" for number in range(len(self.input_sizes))}
        names |= dict.fromkeys(self.empty, "null")
        names |= {number: f"%out{k}" for k, number in enumerate(self.results)}
        lines = []
        for call, name in zip(self.calls, called, strict=True):
            for k, number in enumerate(call.outputs):
                if number not in names:
                    names[number] = f"%value{number}"
                    elements = max(1, call.function.numel_out(k))
                    lines.append(f"  %value{number} = alloca {value_type(lanes)}, i64 {elements}, align 64")
            arguments = ", ".join(f"ptr {names[number]}" for number in (*call.inputs, *call.outputs))
            lines.append(f"  call void @{name}({arguments})")
        inputs = [f"ptr noalias %in{k}" for k in range(len(self.input_sizes))]
        outputs = [f"ptr noalias %out{k}" for k in range(len(self.results))]
        body = "\n".join(lines)
        return f"define void @{symbol}({', '.join([*inputs, *outputs])}) nounwind {{\n{body}\n  ret void\n}}"


def nested_calls(function: ca.Function) -> NestedCalls | None:
    """Read a function that passes its inputs, and what calls return, as a whole to further calls.

    Args:
        function: Any CasADi function.

    Returns:
        Its calls; None for a function that does anything else, or returns an input or a value twice.
    """
    if not function.is_a("MXFunction"):
        return None
    sizes = tuple(function.numel_in(k) for k in range(function.n_in()))
    number_of: dict[int, int] = {}  # by the place in CasADi's work vector, which is used again
    calls, results, empty, count = [], [-1] * function.n_out(), set(), len(sizes)
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        taken, given = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_INPUT and function.instruction_MX(k).numel() == sizes[taken[0]]:
            number_of[given[0]] = taken[0]
        elif operation == ca.OP_CONST and function.instruction_MX(k).numel() == 0:
            number_of[given[0]] = count
            empty.add(count)
            count += 1
        elif operation == ca.OP_CALL:
            outputs = tuple(range(count, count + len(given)))
            called = function.instruction_MX(k).which_function()
            calls.append(NestedCall(called, tuple(number_of[place] for place in taken), outputs))
            number_of |= dict(zip(given, outputs, strict=True))
            count += len(given)
        elif operation == ca.OP_OUTPUT:
            results[given[0]] = number_of[taken[0]]
        else:
            return None
    returned = {number for call in calls for number in call.outputs}
    direct = len(set(results)) == len(results) and returned.issuperset(results)
    return NestedCalls(sizes, tuple(calls), tuple(results), frozenset(empty)) if direct else None


def is_long(function: ca.Function) -> bool:
    """Return whether a function takes so long to compile that it is better compiled once and called."""
    return bool(function.is_a("SXFunction")) and function.n_instructions() > PART_LENGTH
