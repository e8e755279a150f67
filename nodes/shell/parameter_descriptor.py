"""Node parameters as ROS 2 describes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, ParameterType

if TYPE_CHECKING:
    from flexros_nodes.protocol.parameters import ParameterSpecification

_TYPES = {
    "bool": ParameterType.PARAMETER_BOOL,
    "int": ParameterType.PARAMETER_INTEGER,
    "double": ParameterType.PARAMETER_DOUBLE,
    "string": ParameterType.PARAMETER_STRING,
}


def parameter_descriptor(name: str, specification: ParameterSpecification) -> ParameterDescriptor:
    """Describe a parameter to ROS.

    Args:
        name: Parameter.
        specification: Its row in the parameter file.

    Returns:
        Type, description with unit, bounds and whether it is read only.
    """
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
