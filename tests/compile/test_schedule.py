from __future__ import annotations

import casadi as ca

from flexros.compile.elementary import SINCOS
from flexros.compile.schedule import RoutineGroup, operands, schedule
from flexros.compile.sx_graph import SxGraph, read_graph

x = ca.SX.sym("x", 12)


def order_of(*outputs: ca.SX, group_size: int = 8) -> tuple[SxGraph, list[int | RoutineGroup]]:
    graph = read_graph(ca.Function("f", [x], list(outputs)))
    return graph, schedule(graph, group_size)


def test_sine_and_cosine_of_one_angle_are_one_evaluation() -> None:
    _, order = order_of(ca.sin(x[0]) * ca.cos(x[0]))
    assert [len(step.arguments) for step in order if isinstance(step, RoutineGroup)] == [1]


def test_independent_angles_are_gathered_up_to_the_group_size() -> None:
    _, order = order_of(ca.sin(x), group_size=8)
    assert [len(step.arguments) for step in order if isinstance(step, RoutineGroup)] == [8, 4]


def test_a_sine_of_a_sine_waits_for_the_inner_one() -> None:
    _, order = order_of(ca.sin(ca.sin(x[0]) + x[1]), ca.sin(x[1]))
    groups = [step for step in order if isinstance(step, RoutineGroup)]
    assert [len(group.arguments) for group in groups] == [2, 1]
    assert all(group.routine == SINCOS for group in groups)


def test_nothing_is_used_before_it_is_known() -> None:
    mixed = ca.exp(ca.sin(x) * x[0]) + ca.tanh(x**2 + ca.cos(x[3]))
    graph, order = order_of(mixed, ca.sin(mixed))
    known = {k for k, operation in enumerate(graph.operations) if operation in (ca.OP_INPUT, ca.OP_CONST)}
    for step in order:
        assert set(step.arguments if isinstance(step, RoutineGroup) else operands(graph, step)) <= known
        if isinstance(step, RoutineGroup):
            known |= {k for k, first in enumerate(graph.first) if first in step.arguments and k not in order}
        else:
            known.add(step)
    assert {node for _, _, node in graph.outputs} <= known
