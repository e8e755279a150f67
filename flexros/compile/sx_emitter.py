"""Writes an SX graph as LLVM code.

Functions of many thousand instructions are split into parts: the time of register allocation grows faster than
linearly, and few values are needed in several parts. Those are passed in memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.elementary import SINCOS, routine_name
from flexros.compile.ir_text import LANE_COUNTS, IrBlock, alignment, float_literal, value_type
from flexros.compile.operations import COMPARISONS, LOGIC, ROUTINES, is_known, write_number
from flexros.compile.schedule import RoutineGroup, Step, operands, schedule
from flexros.compile.sx_graph import unknown_operation

if TYPE_CHECKING:
    from flexros.compile.sx_graph import SxGraph

PART_LENGTH = 1500  # instructions per part
GROUP_SIZE = 8  # numbers evaluated together by one routine call


@dataclass(frozen=True)
class FunctionText:
    """LLVM text of one function.

    Attributes:
        text: Definitions.
        routines: Routines of `elementary.py` that it calls, as (routine, lanes).
    """

    text: str
    routines: frozenset[tuple[str, int]]


def emit_function(graph: SxGraph, symbol: str, lanes: int) -> FunctionText:
    """Write `void symbol(ptr in0, ..., ptr out0, ...)`.

    Args:
        graph: The function.
        symbol: Name of the LLVM function, without the @.
        lanes: Doubles per number; arrays are then (elements, lanes) with lanes adjacent.
    """
    for operation in set(graph.operations) - {ca.OP_CONST, ca.OP_INPUT}:
        if not is_known(operation):
            raise unknown_operation(operation, graph.name)
    return _FunctionEmitter(graph, symbol, lanes).emit()


class _FunctionEmitter:
    def __init__(self, graph: SxGraph, symbol: str, lanes: int) -> None:
        self.graph = graph
        self.symbol = symbol
        self.lanes = lanes
        self.order = schedule(graph, GROUP_SIZE if lanes == 1 else 1)
        self.part_count = max(1, round(len(self.order) / PART_LENGTH))
        self.part_length = -(-max(1, len(self.order)) // self.part_count)
        self.last_part = self._last_parts()
        self.slots: dict[int, int] = {}
        self.slot_count = 0
        self.routines: set[tuple[str, int]] = set()
        self.results = {
            (operation, graph.first[node]): node
            for node, operation in enumerate(graph.operations)
            if operation in ROUTINES
        }
        self.outputs: dict[int, list[tuple[int, int]]] = {}
        for output, element, node in graph.outputs:
            self.outputs.setdefault(node, []).append((output, element))
        self._start_part(0)

    def _last_parts(self) -> dict[int, int]:
        """Return the last part that uses each node."""
        last: dict[int, int] = {}
        for position, step in enumerate(self.order):
            part = position // self.part_length
            used = step.arguments if isinstance(step, RoutineGroup) else operands(self.graph, step)
            last.update(dict.fromkeys(used, part))
        return last

    def _start_part(self, part: int) -> None:
        self.part = part
        self.block = IrBlock(self.lanes)
        self.names: dict[int, str] = {}
        self.masks: dict[int, str] = {}

    def emit(self) -> FunctionText:
        parts: list[str] = []
        for part in range(self.part_count):
            self._start_part(part)
            if part == 0:
                self._store_leaves()
            for step in self.order[part * self.part_length : (part + 1) * self.part_length]:
                self._step(step)
            parts.append(self.block.text())
        return FunctionText(self._assemble(parts), frozenset(self.routines))

    def _assemble(self, parts: list[str]) -> str:
        names = [f"in{k}" for k in range(len(self.graph.input_sizes))]
        names += [f"out{k}" for k in range(len(self.graph.output_sizes))]
        parameters = ", ".join(f"ptr noalias %{name}" for name in names)
        if self.part_count == 1:
            return f"define void @{self.symbol}({parameters}) nounwind {{\n{parts[0]}\n  ret void\n}}"
        texts = []
        inner = ", ".join([*(f"ptr noalias %{name}" for name in names), "ptr noalias %scratch"])
        arguments = ", ".join([*(f"ptr %{name}" for name in names), "ptr %scratch"])
        calls = [f"  %scratch = alloca {value_type(self.lanes)}, i64 {max(1, self.slot_count)}, align 64"]
        for part, body in enumerate(parts):
            name = f"@{self.symbol}.part{part}"
            texts.append(f"define internal void {name}({inner}) noinline nounwind {{\n{body}\n  ret void\n}}")
            calls.append(f"  call void {name}({arguments})")
        texts.append(f"define void @{self.symbol}({parameters}) nounwind {{\n" + "\n".join(calls) + "\n  ret void\n}")
        return "\n".join(texts)

    def _store_leaves(self) -> None:
        for node in self.outputs:
            if self.graph.operations[node] in (ca.OP_CONST, ca.OP_INPUT):
                self._store_outputs(node)

    def _store_outputs(self, node: int) -> None:
        for output, element in self.outputs.get(node, ()):
            self.block.store(self._number(node), f"%out{output}", element)

    def _step(self, step: Step) -> None:
        if isinstance(step, RoutineGroup):
            self._routine(step)
            return
        operation, a, b = self.graph.operations[step], self.graph.first[step], self.graph.second[step]
        if operation in COMPARISONS:
            self.masks[step] = self.block.compare(COMPARISONS[operation], self._number(a), self._number(b))
        elif operation in LOGIC:
            self.masks[step] = self._logic(operation, a, b)
        elif operation == ca.OP_IF_ELSE_ZERO:
            self.names[step] = self.block.select(self._truth(a), self._number(b), self.block.number(0.0))
        else:
            second = self._number(b) if b >= 0 else ""
            self.names[step] = write_number(self.block, operation, self._number(a), second)
        self._keep(step)

    def _keep(self, node: int) -> None:
        """Store a new value to the outputs, and to memory if later parts use it."""
        if self.last_part.get(node, self.part) > self.part:
            self.slots[node] = self.slot_count
            self.slot_count += 1
            self.block.store(self._number(node), "%scratch", self.slots[node], alignment(self.lanes))
        self._store_outputs(node)

    def _number(self, node: int) -> str:
        """Return the name of a node's value; load it from memory if this part does not have it yet."""
        operation = self.graph.operations[node]
        if operation == ca.OP_CONST:
            return float_literal(self.graph.constants[node], self.lanes)
        if node not in self.names:
            if node in self.masks:
                one, zero = self.block.number(1.0), self.block.number(0.0)
                self.names[node] = self.block.select(self.masks[node], one, zero)
            elif operation == ca.OP_INPUT:
                self.names[node] = self.block.load(f"%in{self.graph.first[node]}", self.graph.second[node])
            else:
                self.names[node] = self.block.load("%scratch", self.slots[node], alignment(self.lanes))
        return self.names[node]

    def _truth(self, node: int) -> str:
        if node not in self.masks:
            self.masks[node] = self.block.compare("une", self._number(node), self.block.number(0.0))
        return self.masks[node]

    def _logic(self, operation: int, a: int, b: int) -> str:
        mask = self.block.mask
        if operation == ca.OP_NOT:
            true = "true" if self.lanes == 1 else "<" + ", ".join(["i1 true"] * self.lanes) + ">"
            return self.block.value(f"xor {mask} {self._truth(a)}, {true}")
        name = "and" if operation == ca.OP_AND else "or"
        return self.block.value(f"{name} {mask} {self._truth(a)}, {self._truth(b)}")

    def _routine(self, group: RoutineGroup) -> None:
        """Call a routine once for the group and assign its results to their nodes."""
        count = len(group.arguments)
        width = self.lanes if self.lanes > 1 else next(n for n in LANE_COUNTS if n >= count)
        self.routines.add((group.routine, width))
        number = value_type(width)
        argument = self._packed(group.arguments, width)
        result = f"{{ {number}, {number} }}" if group.routine == SINCOS else number
        value = self.block.value(f"call {result} {routine_name(group.routine, width)}({number} {argument})")
        members: dict[int | None, str] = {None: value}
        if group.routine == SINCOS:
            members = {k: self.block.value(f"extractvalue {result} {value}, {k}") for k in (0, 1)}
        # one call answers all operations on the same arguments, e.g. both sine and cosine
        for position, node in enumerate(group.arguments):
            for operation, (routine, member) in ROUTINES.items():
                target = self.results.get((operation, node)) if routine == group.routine else None
                if target is None:
                    continue
                name = members[member]
                if width != self.lanes:
                    name = self.block.value(f"extractelement {number} {name}, i32 {position}")
                self.names[target] = name
                self._keep(target)

    def _packed(self, arguments: tuple[int, ...], width: int) -> str:
        if width == self.lanes:
            return self._number(arguments[0])
        # unused lanes repeat the last argument, so that they cannot take the slow branch of a routine alone
        filled = arguments + arguments[-1:] * (width - len(arguments))
        packed, number = "undef", value_type(width)
        for position, node in enumerate(filled):
            packed = self.block.value(f"insertelement {number} {packed}, double {self._number(node)}, i32 {position}")
        return packed
