"""Reads the instruction list of a CasADi SX function into a graph in single-assignment form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

NO_NODE = -1
COMMUTATIVE = frozenset({ca.OP_ADD, ca.OP_MUL})


@dataclass(frozen=True)
class SxGraph:
    """A function as nodes in order of evaluation; equal nodes appear once.

    Attributes:
        name: Name of the function.
        operations: CasADi operation code per node (OP_CONST, OP_INPUT, OP_ADD, ...).
        first: First operand of every node, as a node number (or the input number of OP_INPUT).
        second: Second operand, NO_NODE when there is none (or the element number of OP_INPUT).
        constants: Value per constant node.
        outputs: One (output, element, node) per element of the outputs.
        input_sizes: Number of elements per input.
        output_sizes: Number of elements per output.
    """

    name: str
    operations: Sequence[int]
    first: Sequence[int]
    second: Sequence[int]
    constants: dict[int, float]
    outputs: Sequence[tuple[int, int, int]]
    input_sizes: tuple[int, ...]
    output_sizes: tuple[int, ...]


def dense_sx_function(function: ca.Function) -> ca.Function:
    """Return the function as SX function with dense inputs and outputs.

    Args:
        function: A CasADi function; MX functions are expanded.

    Raises:
        InputError: The function has free variables, sparse inputs, or cannot be expanded to scalar operations.
    """
    name = function.name()
    if function.has_free():
        raise InputError(
            f"function '{name}' depends on {function.get_free()}, which are not among its inputs: "
            "make every symbol an input before compiling"
        )
    sparse = [function.name_in(k) for k in range(function.n_in()) if not function.sparsity_in(k).is_dense()]
    if sparse:
        raise InputError(f"function '{name}' has sparse inputs {sparse}: compiled functions take dense inputs only")
    if not function.is_a("SXFunction"):
        try:
            function = function.expand()
        except RuntimeError as error:
            raise InputError(f"function '{name}' cannot be expanded to scalar operations: {error}") from error
    if all(function.sparsity_out(k).is_dense() for k in range(function.n_out())):
        return function
    inputs = function.sx_in()
    outputs = [ca.densify(out) for out in function.call(inputs)]
    return ca.Function(name, inputs, outputs, function.name_in(), function.name_out())


def read_graph(function: ca.Function) -> SxGraph:
    """Read the instructions of an SX function with dense inputs and outputs.

    Args:
        function: SX function, see `dense_sx_function`.

    Raises:
        InputError: An instruction is not an operation on one or two numbers.
    """
    reader = _GraphReader(function.name())
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        value = function.instruction_constant(k) if operation == ca.OP_CONST else 0.0
        reader.read(operation, function.instruction_input(k), function.instruction_output(k), value)
    return SxGraph(
        name=function.name(),
        operations=reader.operations,
        first=reader.first,
        second=reader.second,
        constants=reader.constants,
        outputs=reader.outputs,
        input_sizes=tuple(function.nnz_in(k) for k in range(function.n_in())),
        output_sizes=tuple(function.nnz_out(k) for k in range(function.n_out())),
    )


class _GraphReader:
    """Follows the work registers of the virtual machine, which are reused, and assigns a node to each value."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.operations: list[int] = []
        self.first: list[int] = []
        self.second: list[int] = []
        self.constants: dict[int, float] = {}
        self.outputs: list[tuple[int, int, int]] = []
        self._known: dict[tuple[int, ...] | str, int] = {}
        self._register: dict[int, int] = {}

    def read(self, operation: int, source: Sequence[int], target: Sequence[int], value: float) -> None:
        """Read one instruction; `value` is that of a constant."""
        register = self._register
        if operation == ca.OP_OUTPUT:
            self.outputs.append((target[0], target[1], register[source[0]]))
        elif operation == ca.OP_CONST:
            node = self._node(float(value).hex(), operation, NO_NODE, NO_NODE)
            self.constants[node] = value
            register[target[0]] = node
        elif operation == ca.OP_INPUT:
            register[target[0]] = self._node((operation, *source), operation, source[0], source[1])
        elif operation in (ca.OP_ASSIGN, ca.OP_LIFT):
            register[target[0]] = register[source[0]]
        elif operation == ca.OP_CALL or not 1 <= len(source) <= 2 or len(target) != 1:
            raise unknown_operation(operation, self.name)
        else:
            a = register[source[0]]
            b = register[source[1]] if len(source) == 2 else NO_NODE
            if operation in COMMUTATIVE and b < a:
                a, b = b, a
            register[target[0]] = self._node((operation, a, b), operation, a, b)

    def _node(self, key: tuple[int, ...] | str, operation: int, a: int, b: int) -> int:
        """Return the node of this key; create it if it is new."""
        node = self._known.get(key)
        if node is None:
            node = self._known[key] = len(self.operations)
            self.operations.append(operation)
            self.first.append(a)
            self.second.append(b)
        return node


def unknown_operation(operation: int, function_name: str) -> InputError:
    """Return the error for a CasADi operation that cannot be compiled, naming it."""
    names = [key for key in dir(ca) if key.startswith("OP_") and getattr(ca, key) == operation]
    name = names[0] if names else f"number {operation}"
    return InputError(
        f"function '{function_name}' uses the CasADi operation {name}, which cannot be compiled: "
        "write the expression with other operations, or evaluate the function with CasADi itself"
    )
