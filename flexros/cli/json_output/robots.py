"""JSON of the commands about robots."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from flexros.cli.json_output.base import Output


class RobotEntry(Output):
    """A built-in robot."""

    name: str = Field(description="its name")
    arm_dof: int = Field(description="arm coordinates N [1]")
    motors: int = Field(description="motors M [1]")
    description: str = Field(description="what it is")


class Eigenvalue(Output):
    """A pole or zero."""

    re: float = Field(description="real part [1/s]")
    im: float = Field(description="imaginary part [1/s]")
    hz: float = Field(description="absolute value over 2 pi [Hz]")


class RobotAtPose(Output):
    """Modes, zeros and zero dynamics of a robot at a pose."""

    robot: str = Field(description="name of the robot")
    q: list[float] = Field(description="arm coordinates [rad or m]")
    output: str = Field(description="controlled output")
    poles: list[Eigenvalue] = Field(description="poles by ascending size")
    zeros: dict[str, dict[str, list[Eigenvalue]]] = Field(description="zeros of each channel, by motor and measurement")
    transmission_zeros: list[Eigenvalue] = Field(description="from all torques to the output")
    zero_dynamics: list[Eigenvalue] = Field(description="of the controlled output")
    minimum_phase: bool = Field(description="whether a causal feedforward exists")


class ImportedJoint(Output):
    """A joint of an imported model."""

    coordinate: str = Field(description="coordinate of the robot file")
    joint: str = Field(description="joint of the model")
    sign: int = Field(description="1, or -1 where it counts the other way")
    reference: float = Field(description="its position where the coordinate is zero [rad or m]")


class NotHeld(Output):
    """A number that a file cannot hold."""

    location: str = Field(description="motor, spring or body")
    name: str = Field(description="effect or quantity")
    size: str = Field(description="its values with units")
    reason: str = Field(description="why it is not held")


class ImportedModel(Output):
    """A robot file made from a URDF or an MJCF."""

    robot: str = Field(description="the robot file")
    patch: str | None = Field(
        default=None, description="the patch with what a robot file cannot state; none where there is nothing"
    )
    effects: list[dict[str, Any]] = Field(description="effects in the patch")
    joints: list[ImportedJoint] = Field(description="joints in the order of the chain")
    not_held: list[NotHeld] = Field(description="what neither file holds")
    notes: list[str] = Field(description="what the robot file holds otherwise than the file, in sentences")


class Written(Output):
    """A number that was written into the file of another program."""

    location: str = Field(description="motor, spring or body")
    quantity: str = Field(description="the quantity")
    place: str = Field(description="element and attribute of the file")
    before: float | None = Field(default=None, description="value before, in `unit`")
    value: float = Field(description="value written, in `unit`")
    unit: str = Field(description="SI unit")


class ExportedModel(Output):
    """A robot or patch written for another program."""

    out: str = Field(description="the file")
    format: str = Field(description="mjcf, urdf, sdf or json")
    base: str | None = Field(default=None, description="the file that was copied with new numbers")
    written: list[Written] = Field(description="numbers that were written")
    not_held: list[NotHeld] = Field(description="what the format has no place for")
