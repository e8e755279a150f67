from __future__ import annotations

from dataclasses import replace

import casadi as ca
import pytest

from flexros.compile import LoopFunctions
from flexros.compile.loop.functions import loop_sizes
from flexros.errors import InputError


def test_sizes_are_read_off_the_functions(chain: LoopFunctions) -> None:
    sizes = loop_sizes(chain)
    assert (sizes.state, sizes.motors, sizes.controller, sizes.reference) == (10, 2, 5, 6)
    assert (sizes.gains, sizes.parameters, sizes.pose, sizes.disturbance) == (3, 2, 7, 8)


def test_wrong_number_of_arguments_is_named(chain: LoopFunctions) -> None:
    q, p = ca.SX.sym("q", 5), ca.SX.sym("p", 2)
    wrong = replace(chain, encoder=ca.Function("encoder", [q, p], [q]))
    with pytest.raises(InputError, match="loop function 'encoder' has 2 inputs and 1 outputs: it must have 1 and 1"):
        loop_sizes(wrong)


@pytest.mark.parametrize(
    "name", ["derivative", "encoder", "tool_pose", "controller", "sensor", "exact_update", "before_step", "after_step"]
)
def test_function_that_does_not_fit_the_others_is_named(chain: LoopFunctions, name: str) -> None:
    shapes = {
        "derivative": ((10, 2, 5, 2), (10,)),
        "encoder": ((11,), (2,)),
        "tool_pose": ((3, 1), (7,)),
        "controller": ((5, 6, 3, 3), (2, 5)),
        "sensor": ((3, 10, 2), (3,)),
        **dict.fromkeys(("exact_update", "before_step", "after_step"), ((10, 2, 6, 2, 1), (9,))),
    }
    inputs, outputs = shapes[name]
    symbols = [ca.SX.sym(f"s{k}", size) for k, size in enumerate(inputs)]
    wrong = replace(chain, **{name: ca.Function("f", symbols, [ca.SX.zeros(size) for size in outputs])})
    with pytest.raises(InputError, match=f"loop function '{name}' maps sizes"):
        loop_sizes(wrong)
