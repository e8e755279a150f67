"""The parameters of a node: declared, described and checked from data, and taken over when they change."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.lifecycle import LifecycleNode
from rclpy.parameter import Parameter

from flexros.errors import InputError
from flexros_nodes.protocol.parameters import check_value
from flexros_nodes.shell.parameter_descriptor import parameter_descriptor

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rclpy.context import Context

    from flexros_nodes.protocol.parameters import ParameterSpecification, Value


class AbstractParameterNode(LifecycleNode):
    """A lifecycle node whose parameters are data.

    Args:
        name: Name of the node.
        context: ROS context; the default one if None.
        values: Parameter values that override files and defaults.

    Attributes:
        configured: Whether the node has taken its parameters; only then a change is handed on.
    """

    def __init__(self, name: str, context: Context | None, values: Mapping[str, Value]) -> None:
        overrides = [Parameter(parameter, value=value) for parameter, value in values.items()]
        super().__init__(name, context=context, parameter_overrides=overrides)
        self.configured = False
        self._specifications: dict[str, ParameterSpecification] = {}
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._take_parameters)

    def declare(self, specifications: Mapping[str, ParameterSpecification]) -> None:
        """Declare and check parameters.

        Args:
            specifications: Specifications by parameter name; names declared before are left alone.

        Raises:
            InputError: A value that was given is not allowed.
        """
        for name, specification in specifications.items():
            if self.has_parameter(name):
                continue
            untyped = ParameterDescriptor(dynamic_typing=True)
            given = self.declare_parameter(name, specification.default, untyped).value  # unchecked: not known as yet
            self._specifications[name] = specification
            value = check_value(self.get_name(), name, given, self._specifications)
            if type(value) is not type(given):
                self.set_parameters([Parameter(name, value=value)])
            self.set_descriptor(name, parameter_descriptor(name, specification))

    def value(self, name: str) -> Any:
        """Give the value of a parameter, in the unit of its file."""
        return self.get_parameter(name).value

    def parameters_changed(self, values: Mapping[str, Value]) -> None:
        """Take over parameters of a configured node that were changed; they are checked already."""

    def _check_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        try:
            for parameter in self._known(parameters):
                check_value(self.get_name(), parameter.name, parameter.value, self._specifications)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_parameters(self, parameters: Sequence[Parameter]) -> None:
        if self.configured and (known := self._known(parameters)):
            self.parameters_changed({parameter.name: parameter.value for parameter in known})

    def _known(self, parameters: Sequence[Parameter]) -> list[Parameter]:
        return [parameter for parameter in parameters if parameter.name in self._specifications]

    def undeclare(self, names: Iterable[str]) -> None:
        """Forget parameters, so that they may be declared anew with other defaults."""
        for name in names:
            del self._specifications[name]
            self.undeclare_parameter(name)
