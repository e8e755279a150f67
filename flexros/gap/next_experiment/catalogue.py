"""Catalogue of experiments that can separate explanations, each a variant of the diagnosis experiment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexros.effects.payload_error import PayloadError
from flexros.errors import InputError
from flexros.identify.design.default_controller import default_controller

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.robot import Robot

HIGH_BAND = (0.05, 0.3)
"""Lowest and highest line of the high-band experiment as shares of the sampling rate [1] (chosen)."""
ADDED_LOAD = 0.5
"""Known load that is added, relative to the mass of the last body [1] (chosen)."""
SOFTER = 4.0
"""Factor by which the gains of the soft controller are lower; its damping gain by the square root [1] (chosen)."""
LONG_REST = 2.0
"""Time of each static hold [s] (chosen)."""


@dataclass(frozen=True)
class CatalogueEntry:
    """An experiment of the catalogue.

    Attributes:
        name: Name in the catalogue.
        description: What is done and what it separates, one sentence.
        settings: Keys of scenario `diagnosis` that differ, by dotted name, as a function of the robot.
        tool: Whether the tool is measured as well.
    """

    name: str
    description: str
    settings: Callable[[Robot], Mapping[str, Any]]
    tool: bool = False

    def keys(self, robot: Robot, length: float) -> dict[str, Any]:
        """Return the keys of scenario `diagnosis` that differ, including the length [s].

        Args:
            robot: The nominal robot.
            length: Approximate length of the experiment [s].
        """
        return {"diagnosis.length": length, **self.settings(robot)}


def _soft(robot: Robot) -> Mapping[str, Any]:
    law = default_controller(robot, robot.sample_time)
    gains = {key: _each(getattr(law, key), factor) for key, factor in (("kp", SOFTER), ("ki", SOFTER), ("kd", 2.0))}
    return {"controller": {"kind": law.kind, **gains, "derivative_filter": law.derivative_filter}}


def _each(gain: float | tuple[float, ...], divisor: float) -> list[float]:
    values = gain if isinstance(gain, tuple) else (gain,)
    return [float(f"{value / divisor:.3g}") for value in values]


def _loaded(robot: Robot) -> Mapping[str, Any]:
    if not PayloadError().locations(robot):
        raise InputError(f"the last body of robot {robot.name} has no mass, of which a load could be half")
    added = PayloadError(relative=ADDED_LOAD).values(robot, "tool")
    return {f"model.values.{name}": float(f"{value:.6g}") for name, value in added.items() if value}


CATALOGUE = (
    CatalogueEntry(
        "standard",
        "run the diagnosis experiment, which excites all effects of the library, or repeat it with another seed",
        lambda _: {},
    ),
    CatalogueEntry(
        "creep_in_poses",
        "creep both ways in three poses: gravity depends on the pose, friction on the direction, a bias on neither",
        lambda _: {"diagnosis.parts": ["creep"] * 3},
    ),
    CatalogueEntry(
        "sub_breakaway",
        "small slow reversals below breakaway in three poses: bristles and hysteresis deflect before they slide",
        lambda _: {"diagnosis.parts": ["presliding"] * 3, "diagnosis.reversal": 0.1},
    ),
    CatalogueEntry(
        "biased_small_motion",
        "small multisine on a slow swing that keeps the gear loaded on one side: backlash closes, friction remains",
        lambda _: {"diagnosis.parts": ["biased"] * 3, "diagnosis.levels": [0.02], "diagnosis.bias": 0.6},
    ),
    CatalogueEntry(
        "high_band",
        "multisines up to high frequencies: a lag changes magnitude and phase, a delay only phase",
        lambda robot: {
            "diagnosis.parts": ["multisine"],
            "diagnosis.lowest": float(f"{HIGH_BAND[0] / robot.sample_time:.3g}"),
            "diagnosis.highest": float(f"{HIGH_BAND[1] / robot.sample_time:.3g}"),
            "diagnosis.levels": [0.3, 0.3],
        },
    ),
    CatalogueEntry(
        "static_holds",
        "long rests in many poses: loads at rest do not depend on inertia, damping or friction of motion",
        lambda _: {"diagnosis.parts": ["moves"], "diagnosis.dwell": LONG_REST, "diagnosis.intensity": 0.5},
    ),
    CatalogueEntry(
        "speed_run_ups",
        "steady runs at four speeds: errors that repeat per turn keep their order, resonances their frequency",
        lambda _: {"diagnosis.parts": ["creep"], "diagnosis.creep_speeds": [1.0, 2.0, 4.0, 8.0]},
    ),
    CatalogueEntry(
        "fast_moves",
        "fast moves near the limits of speed and torque: saturation, inertia and delay",
        lambda _: {"diagnosis.parts": ["moves", "steps"], "diagnosis.intensity": 1.2},
    ),
    CatalogueEntry(
        "soft_controller",
        "the diagnosis experiment with a softer controller: effects that depend on the feedback change, others do not",
        _soft,
    ),
    CatalogueEntry(
        "known_payload",
        "mount a known load of half the mass of the last body, write it into the robot file and repeat: separates "
        "inertia from torque gain, of which only the ratio was identifiable",
        _loaded,
    ),
    CatalogueEntry(
        "tool_measurement",
        "measure the tool position in the diagnosis experiment: motor positions do not show the deflection of the arm",
        lambda _: {},
        tool=True,
    ),
)
"""The experiments, in the order of their cost to the user."""
