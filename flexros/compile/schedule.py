"""Order of evaluation: groups sines, exponentials, logarithms and hyperbolic tangents that can be evaluated together.

All joint angles of a robot are inputs, so their sines and cosines fill the lanes of one vector evaluation even if the
function itself works on single numbers. Neither lanes nor grouping change the results.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import casadi as ca

from flexros.compile.operations import ROUTINES

if TYPE_CHECKING:
    from flexros.compile.sx_graph import SxGraph

LEAVES = (ca.OP_CONST, ca.OP_INPUT)


@dataclass(frozen=True)
class RoutineGroup:
    """Evaluations of one routine with mutually independent arguments.

    Attributes:
        routine: Name of the routine, see `elementary.py`.
        arguments: Node number of every argument.
    """

    routine: str
    arguments: tuple[int, ...]


Step: TypeAlias = "int | RoutineGroup"


def schedule(graph: SxGraph, group_size: int) -> list[Step]:
    """Order the nodes such that all arguments of a group of routine evaluations precede it.

    Args:
        graph: The function.
        group_size: Largest number of evaluations in a group.

    Returns:
        Node numbers and groups, without constants, inputs and nodes evaluated by a group.
    """
    groups = _groups(graph, group_size)
    placed = bytearray(len(graph.operations))
    order: list[Step] = []

    def place(node: int) -> None:
        placed[node] = 1
        operation = graph.operations[node]
        if operation in LEAVES:
            return
        if operation not in ROUTINES:
            order.append(node)
            return
        group = groups[ROUTINES[operation][0], graph.first[node]]
        if group in done:
            return
        done.add(group)
        for ancestor in _missing_ancestors(graph, group.arguments, placed):
            if not placed[ancestor]:
                place(ancestor)
        order.append(group)

    done: set[RoutineGroup] = set()
    for node in range(len(graph.operations)):
        if not placed[node]:
            place(node)
    return order


def operands(graph: SxGraph, node: int) -> tuple[int, ...]:
    """Return the nodes that a node is computed from."""
    if graph.operations[node] in LEAVES:
        return ()
    second = graph.second[node]
    return (graph.first[node],) if second < 0 else (graph.first[node], second)


def _groups(graph: SxGraph, group_size: int) -> dict[tuple[str, int], RoutineGroup]:
    """Group arguments by routine and by the number of routines that must be evaluated before."""
    depth = [0] * len(graph.operations)
    waiting: dict[tuple[str, int], dict[int, None]] = {}
    for node, operation in enumerate(graph.operations):
        below = max((depth[k] for k in operands(graph, node)), default=0)
        depth[node] = below + (operation in ROUTINES)
        if operation in ROUTINES:
            waiting.setdefault((ROUTINES[operation][0], below), {})[graph.first[node]] = None
    result: dict[tuple[str, int], RoutineGroup] = {}
    for (routine, _), arguments in waiting.items():
        for start in range(0, len(arguments), group_size):
            group = RoutineGroup(routine, tuple(arguments)[start : start + group_size])
            result.update({(routine, argument): group for argument in group.arguments})
    return result


def _missing_ancestors(graph: SxGraph, nodes: tuple[int, ...], placed: bytearray) -> list[int]:
    missing: set[int] = set()
    stack = list(nodes)
    while stack:
        node = stack.pop()
        if not placed[node] and node not in missing:
            missing.add(node)
            stack.extend(operands(graph, node))
    return sorted(missing)
