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


class Stages:
    """Collects the calls of a function while its result is written with symbols for what they return.

    Args:
        arguments: Symbols on which the function depends.
    """

    def __init__(self, arguments: Sequence[ca.SX]) -> None:
        self._arguments = list(arguments)
        self._calls: list[tuple[ca.Function, list[ca.SX], list[ca.SX]]] = []

    def call(self, function: ca.Function, *inputs: ca.SX) -> list[ca.SX]:
        """Return the outputs of a function: symbols where it is long, else what it returns.

        Args:
            function: Function of SX.
            inputs: Its inputs, which depend on the arguments alone.
        """
        if not is_long(function):
            return list(function.call(list(inputs)))
        outputs = [ca.SX.sym(f"out{k}", *function.size_out(k)) for k in range(function.n_out())]
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
        inputs = [ca.densify(value) for _, values, _ in self._calls for value in values]
        outputs = [symbol for _, _, symbols in self._calls for symbol in symbols]
        before = ca.Function(f"{name}_before", self._arguments, inputs, options)
        after = ca.Function(f"{name}_after", [*self._arguments, *outputs], [ca.densify(result)], options)
        given = [ca.MX.sym(f"in{k}", *symbol.size()) for k, symbol in enumerate(self._arguments)]
        values = list(before.call(given))
        returned: list[ca.MX] = []
        for function, taken, _ in self._calls:
            returned += function.call([values.pop(0) for _ in taken])
        return ca.Function(name, given, after.call([*given, *returned]))
