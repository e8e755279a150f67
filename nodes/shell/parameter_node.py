"""Parameters of a node, declared, described and checked from data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    SetParametersResult,
)
from rclpy.lifecycle import LifecycleNode
from rclpy.parameter import Parameter

from flexros.errors import InputError
from flexros_nodes.protocol.parameters import check_value

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rclpy.context import Context

    from flexros_nodes.protocol.parameters import ParameterSpecification, Value


_TYPES = {
    "bool": ParameterType.PARAMETER_BOOL,
    "int": ParameterType.PARAMETER_INTEGER,
    "double": ParameterType.PARAMETER_DOUBLE,
    "string": ParameterType.PARAMETER_STRING,
}


def parameter_descriptor(name: str, specification: ParameterSpecification) -> ParameterDescriptor:
    """Return the ROS description of a parameter: type, text with unit, bounds and whether it is read-only."""
    unit = f" [{specification.unit}]" if specification.unit else ""
    descriptor = ParameterDescriptor(
        name=name,
        type=_TYPES[specification.type],
        description=specification.description + unit,
        additional_constraints="" if specification.allowed is None else "one of " + ", ".join(specification.allowed),
        read_only=specification.read_only,
    )
    if specification.bounds is not None:
        low, high = specification.bounds
        if specification.type == "int":
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=0)]
        else:
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high, step=0.0)]
    return descriptor


class AbstractParameterNode(LifecycleNode):
    """Lifecycle node whose parameters are data.

    Args:
        name: Name of the node.
        context: ROS context; the default one if None.
        values: Parameter values that override files and defaults.

    Attributes:
        configured: Whether the node is configured; only then changes are passed on.
    """

    def __init__(self, name: str, context: Context | None, values: Mapping[str, Value]) -> None:
        overrides = [Parameter(parameter, value=value) for parameter, value in values.items()]
        super().__init__(name, context=context, parameter_overrides=overrides)
        self.configured = False
        self._specifications: dict[str, ParameterSpecification] = {}
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._apply_parameters)

    def declare(self, specifications: Mapping[str, ParameterSpecification]) -> None:
        """Declare and check parameters.

        Args:
            specifications: Specifications by parameter name; names already declared are skipped.

        Raises:
            InputError: A given value is not allowed.
        """
        for name, specification in specifications.items():
            if self.has_parameter(name):
                continue
            untyped = ParameterDescriptor(dynamic_typing=True)
            given = self.declare_parameter(
                name, specification.default, untyped
            ).value  # checked below, once its specification is known
            self._specifications[name] = specification
            value = check_value(self.get_name(), name, given, self._specifications)
            if type(value) is not type(given):
                self.set_parameters([Parameter(name, value=value)])
            self.set_descriptor(name, parameter_descriptor(name, specification))

    def value(self, name: str) -> Any:
        """Return the value of a parameter, in the unit of its file."""
        return self.get_parameter(name).value

    def parameters_changed(self, values: Mapping[str, Value]) -> None:
        """Apply changed parameters of a configured node; their values are checked."""

    def _check_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        try:
            for parameter in self._known(parameters):
                check_value(self.get_name(), parameter.name, parameter.value, self._specifications)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply_parameters(self, parameters: Sequence[Parameter]) -> None:
        if self.configured and (known := self._known(parameters)):
            self.parameters_changed({parameter.name: parameter.value for parameter in known})

    def _known(self, parameters: Sequence[Parameter]) -> list[Parameter]:
        return [parameter for parameter in parameters if parameter.name in self._specifications]

    def undeclare(self, names: Iterable[str]) -> None:
        """Undeclare parameters, so that they can be declared with other defaults."""
        for name in names:
            del self._specifications[name]
            self.undeclare_parameter(name)
