"""Physical quantities in robot files: a value with unit, source and tolerance."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field

from flexros.config.settings import Settings


class Quantity(Settings):
    """One value of a robot file.

    In YAML either a plain number in the SI unit of its key, or a mapping with the fields below.
    """

    value: float = Field(description="value in the SI unit of the key")
    unit: str = Field("", description="unit; optional, must be the SI unit of the key")
    source: str = Field("", description="origin of the value; default: the file's defaults.source")
    tolerance: float | None = Field(
        None, ge=0, description="one standard deviation, relative to the value; default: the file's defaults.tolerance"
    )


class Vector(Settings):
    """Three values of a robot file along x, y and z; in YAML a list of three or a mapping like Quantity."""

    value: tuple[float, float, float] = Field(description="components along x, y, z in the SI unit of the key")
    unit: str = Field("", description="unit; optional, must be the SI unit of the key")
    source: str = Field("", description="origin of the value")
    tolerance: float | None = Field(None, ge=0, description="one standard deviation, relative to the value")


def _from_plain(data: Any) -> Any:
    """Accept a bare number or list where a quantity is expected."""
    if isinstance(data, bool):
        raise ValueError(f"is {data}, but a number is expected")
    return data if isinstance(data, (dict, Quantity, Vector)) else {"value": data}


class _Checked:
    """Check of unit and sign of a quantity."""

    def __init__(self, unit: str, minimum: float | None) -> None:
        self.unit = unit
        self.minimum = minimum

    def __call__(self, quantity: Quantity) -> Quantity:
        check_unit(quantity, self.unit)
        if self.minimum is not None and quantity.value < self.minimum:
            raise ValueError(f"is {quantity.value:g} {self.unit}, but must be at least {self.minimum:g} {self.unit}")
        return quantity.model_copy(update={"unit": self.unit})


UNITS = {
    "position": ("rad", "m"),
    "inertia": ("kg m2", "kg"),
    "torque": ("Nm", "N"),
    "speed": ("rad/s", "m/s"),
    "stiffness": ("Nm/rad", "N/m"),
    "damping": ("Nm s/rad", "N s/m"),
    "integral": ("Nm/(rad s)", "N/(m s)"),
}
"""SI units of the quantities of one direction of motion: for a rotation, for a translation."""


def unit_of(kind: str, rotary: bool) -> str:
    """Return the SI unit of a kind of `UNITS` for a rotation or a translation."""
    return UNITS[kind][0 if rotary else 1]


def check_unit(quantity: Quantity | Vector, unit: str, key: str = "") -> None:
    """Refuse a quantity whose unit is not that of its key.

    Args:
        quantity: The quantity in the file.
        unit: SI unit of the key.
        key: Its key; prefix of the error message.

    Raises:
        ValueError: The units differ.
    """
    if quantity.unit and _canonical(quantity.unit) != _canonical(unit):
        prefix = f"{key} " if key else ""
        raise ValueError(f"{prefix}has unit '{quantity.unit}', but the unit here is '{unit}'; convert the value")


def _canonical(unit: str) -> str:
    return unit.replace("·", "").replace("*", "").replace(" ", "").replace("^", "")


def _checked_vector(unit: str) -> Any:
    def check(vector: Vector) -> Vector:
        check_unit(vector, unit)
        return vector.model_copy(update={"unit": unit})

    return check


def at_least_zero(quantity: Quantity) -> Quantity:
    """Refuse a negative quantity."""
    if quantity.value < 0:
        raise ValueError(f"is {quantity.value:g}, but must not be negative")
    return quantity


def positive(quantity: Quantity) -> Quantity:
    """Refuse a quantity that is zero or negative."""
    if quantity.value <= 0:
        raise ValueError(f"is {quantity.value:g}, but must be positive")
    return quantity


Plain = BeforeValidator(_from_plain)
NotNegative = Annotated[Quantity, Plain, AfterValidator(at_least_zero)]
Positive = Annotated[Quantity, Plain, AfterValidator(positive)]
Mass = Annotated[Quantity, Plain, AfterValidator(_Checked("kg", 0.0))]
Inertia = Annotated[Quantity, Plain, AfterValidator(_Checked("kg m2", 0.0))]
InertiaProduct = Annotated[Quantity, Plain, AfterValidator(_Checked("kg m2", None))]
Length = Annotated[Quantity, Plain, AfterValidator(_Checked("m", 0.0))]
RotaryFriction = Annotated[Quantity, Plain, AfterValidator(_Checked("Nm s/rad", 0.0))]
Seconds = Annotated[Quantity, Plain, AfterValidator(_Checked("s", 0.0))]
Hertz = Annotated[Quantity, Plain, AfterValidator(_Checked("Hz", None)), AfterValidator(positive)]
Ratio = Annotated[Quantity, Plain, AfterValidator(_Checked("1", None))]
AnyUnit = Annotated[Quantity, Plain]
Position = Annotated[Vector, Plain, AfterValidator(_checked_vector("m"))]
Angles = Annotated[Vector, Plain, AfterValidator(_checked_vector("rad"))]
TurningRate = Annotated[Vector, Plain, AfterValidator(_checked_vector("rad/s"))]
Acceleration = Annotated[Vector, Plain, AfterValidator(_checked_vector("m/s2"))]
