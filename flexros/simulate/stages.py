"""Functions of a plant in stages: what goes into the dynamics of a long arm, the dynamics, what becomes of them.

The dynamics are the same whatever the laws of the plant. As a function that is called they are compiled once, and not
again for every set of laws.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.nested_calls import is_long

if TYPE_CHECKING:
    from collections.abc import Sequence

    _Call = tuple[ca.Function, list[ca.SX], list[ca.SX]]


class Stages:
    """Collects the calls of a function while its result is written with symbols for what they return.

    Args:
        arguments: Symbols on which the function depends.
    """

    def __init__(self, arguments: Sequence[ca.SX]) -> None:
        self._arguments = list(arguments)
        self._calls: list[_Call] = []

    def call(self, function: ca.Function, *inputs: ca.SX) -> list[ca.SX]:
        """Return the outputs of a function: symbols where it is long, else what it returns.

        Args:
            function: Function of SX.
            inputs: Its inputs, which depend on the arguments and on what earlier calls return.
        """
        if not is_long(function):
            return list(function.call(list(inputs)))
        outputs = [ca.SX.sym(f"out{len(self._calls)}_{k}", *function.size_out(k)) for k in range(function.n_out())]
        self._calls.append((function, list(inputs), outputs))
        return outputs

    def function(self, name: str, result: ca.SX) -> ca.Function:
        """Return the function of the arguments, one of SX where nothing long is called.

        Args:
            name: Its name.
            result: Its value, which depends on the arguments and on what the calls return.
        """
        options = {"cse": True}
        if not self._calls:
            return ca.Function(name, self._arguments, [ca.densify(result)], options)
        known = list(self._arguments)
        given = values = [ca.MX.sym(f"in{k}", *symbol.size()) for k, symbol in enumerate(known)]
        for number, calls in enumerate(self._rounds()):
            inputs = [ca.densify(value) for _, taken, _ in calls for value in taken]
            before = list(ca.Function(f"{name}_before{number}", known, inputs, options).call(values))
            for function, taken, outputs in calls:
                values = [*values, *function.call([before.pop(0) for _ in taken])]
                known += outputs
        after = ca.Function(f"{name}_after", known, [ca.densify(result)], options)
        return ca.Function(name, given, after.call(values))

    def _rounds(self) -> list[list[_Call]]:
        """Divide the calls, in their order, into rounds that need nothing of their own round."""
        rounds: list[list[_Call]] = [[]]
        for call in self._calls:
            returned = [symbol for _, _, outputs in rounds[-1] for symbol in outputs]
            if returned and ca.depends_on(_column(call[1]), _column(returned)):
                rounds.append([])
            rounds[-1].append(call)
        return rounds


def _column(values: Sequence[ca.SX]) -> ca.SX:
    """Return all elements of some matrices below each other."""
    return ca.vertcat(*[ca.vec(ca.densify(value)) for value in values])
