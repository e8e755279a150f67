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
    """Return the function as SX function with dense inputs and outputs, whatever form it was built in.

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
    """
    operations: list[int] = []
    first: list[int] = []
    second: list[int] = []
    constants: dict[int, float] = {}
    outputs: list[tuple[int, int, int]] = []
    known: dict[tuple[int, int, int] | tuple[str, str], int] = {}
    register: dict[int, int] = {}

    def node(key: tuple[int, int, int] | tuple[str, str], operation: int, a: int, b: int) -> int:
        found = known.get(key)
        if found is None:
            found = known[key] = len(operations)
            operations.append(operation)
            first.append(a)
            second.append(b)
        return found

    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        source = function.instruction_input(k)
        target = function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            outputs.append((target[0], target[1], register[source[0]]))
        elif operation == ca.OP_CONST:
            value = function.instruction_constant(k)
            new = node(("constant", float(value).hex()), operation, NO_NODE, NO_NODE)
            constants[new] = value
            register[target[0]] = new
        elif operation == ca.OP_INPUT:
            register[target[0]] = node((operation, source[0], source[1]), operation, source[0], source[1])
        elif operation in (ca.OP_ASSIGN, ca.OP_LIFT):
            register[target[0]] = register[source[0]]
        else:
            if operation == ca.OP_CALL or not 1 <= len(source) <= 2 or len(target) != 1:
                raise unknown_operation(operation, function.name())
            a = register[source[0]]
            b = register[source[1]] if len(source) == 2 else NO_NODE
            if operation in COMMUTATIVE and b < a:
                a, b = b, a
            register[target[0]] = node((operation, a, b), operation, a, b)
    return SxGraph(
        function.name(), operations, first, second, constants, outputs,
        tuple(function.nnz_in(k) for k in range(function.n_in())),
        tuple(function.nnz_out(k) for k in range(function.n_out())),
    )  # fmt: skip


def unknown_operation(operation: int, function_name: str) -> InputError:
    """Make the error for a CasADi operation that cannot be compiled, naming it."""
    names = [key for key in dir(ca) if key.startswith("OP_") and getattr(ca, key) == operation]
    name = names[0] if names else f"number {operation}"
    return InputError(
        f"function '{function_name}' uses the CasADi operation {name}, which the compiler does not know: "
        "write the expression with other operations, or evaluate the function with CasADi itself"
    )
