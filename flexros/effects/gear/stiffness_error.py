"""Error of a spring's stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.effects.kinds.relative_error import AbstractRelativeError

if TYPE_CHECKING:
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot


class StiffnessError(AbstractRelativeError):
    """The whole law of one spring scaled, linear or not."""

    name: ClassVar[str] = "stiffness_error"
    stage: ClassVar[Stage] = "gear"
    signatures: ClassVar[tuple[str, ...]] = ("torsion_over_torque", "frequency_response", "detection_lines")
    fingerprint: ClassVar[str] = (
        "antiresonance and resonance of the joint both shift, the response at low frequencies is unchanged"
    )

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the springs."""
        return tuple(name for name in robot.arm_names if f"{name}.stiffness" in robot.parameters)

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the stiffness of the spring."""
        del robot
        return (f"{location}.stiffness",)
