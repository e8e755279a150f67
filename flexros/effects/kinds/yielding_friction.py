"""Dry friction whose contacts may yield: held rigidly, or by bristles once they have a stiffness."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.ranges import Range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot import Robot

SOFTEST = 0.5
"""Least stiffness of bristles, over largest torque and range of the motion [1] (chosen): softer ones, which bend by a
good part of the way before they slip, are a spring. Such had stood for a cable that pulled over half a metre."""
BRISTLES: Mapping[str, Range] = MappingProxyType(
    {
        "stiffness": Range("torque/angle", SOFTEST, 1e9, starts=1, vanishes="never"),
        "damping": Range("torque/speed", 1e-6, 1e6, starts=1),
    }
)
"""Ranges of the parameters of bristles."""


def bristle_stiffness() -> Any:
    """Return the field of the stiffness that a member declares."""
    return Field(0.0, ge=0.0, description="bristle stiffness [Nm/rad or N/m]; 0 for rigid contacts")


def bristle_damping() -> Any:
    """Return the field of the damping that a member declares."""
    return Field(0.0, ge=0.0, description="damping of these bristles [Nm s/rad or N s/m]")


class AbstractYieldingFriction(AbstractDryFriction):
    """Dry friction at a motor whose contacts may yield by less than the encoder shows.

    A member provides what an `AbstractDryFriction` does, the fields `stiffness` and `damping`, ranges with those of
    `BRISTLES`, and `acting`. A diagnosis fits the bristles of a friction that it has found.
    """

    unsaid: ClassVar[tuple[str, ...]] = tuple(BRISTLES)

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the ranges without those of bristles, which are fitted once the effect is found."""
        del robot, location
        return {name: allowed for name, allowed in self.ranges.items() if name not in BRISTLES}
