"""Experiments that can separate explanations which a log cannot, each a variant of the diagnosis experiment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexros.effects.payload_error import PayloadError
from flexros.identify.design.default_controller import default_controller

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.robot import Robot

LENGTH = 20.0
"""Length of an experiment of the catalogue, about [s] (chosen)."""
HIGH_BAND = (0.05, 0.3)
"""Lowest and highest line of the experiment in a high band as shares of the sampling rate [1] (chosen)."""
ADDED_LOAD = 0.5
"""Known load that is added, relative to the last body [1] (chosen)."""
SOFTER = 4.0
"""Factor by which the soft controller is softer; its damping goes with the root [1] (chosen)."""
LONG_REST = 2.0
"""Rest in every pose of the static holds [s] (chosen)."""


@dataclass(frozen=True)
class CatalogueEntry:
    """An experiment of the catalogue.

    Attributes:
        name: Name in the catalogue.
        description: What is done and what it tells, one sentence.
        settings: Makes the keys of scenario `diagnosis` that differ, by dotted name, for a robot.
        tool: Whether the tool is measured as well.
    """

    name: str
    description: str
    settings: Callable[[Robot], Mapping[str, Any]]
    tool: bool = False

    def keys(self, robot: Robot) -> dict[str, Any]:
        """Give the keys of scenario `diagnosis` that differ, the length among them.

        Args:
            robot: The nominal robot.
        """
        return {"diagnosis.length": LENGTH, **self.settings(robot)}


def _soft(robot: Robot) -> Mapping[str, Any]:
    law = default_controller(robot, robot.sample_time)
    gains = {key: _each(getattr(law, key), factor) for key, factor in (("kp", SOFTER), ("ki", SOFTER), ("kd", 2.0))}
    return {"controller": {"kind": law.kind, **gains, "derivative_filter": law.derivative_filter}}


def _each(gain: float | tuple[float, ...], divisor: float) -> list[float]:
    values = gain if isinstance(gain, tuple) else (gain,)
    return [float(f"{value / divisor:.3g}") for value in values]


def _loaded(robot: Robot) -> Mapping[str, Any]:
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
        "small slow reversals below breakaway in three poses: bristles and hysteresis bend before they slide",
        lambda _: {"diagnosis.parts": ["presliding"] * 3, "diagnosis.reversal": 0.1},
    ),
    CatalogueEntry(
        "biased_small_motion",
        "small multisine on a slow swing that keeps the gear loaded one way: a gap closes, friction stays",
        lambda _: {"diagnosis.parts": ["biased"] * 3, "diagnosis.levels": [0.02], "diagnosis.bias": 0.6},
    ),
    CatalogueEntry(
        "high_band",
        "multisines up to high frequencies: a lag takes magnitude and phase, a delay phase alone",
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
        "steady runs at four speeds: what repeats per turn keeps its order, resonances keep their frequency",
        lambda _: {"diagnosis.parts": ["creep"], "diagnosis.creep_speeds": [1.0, 2.0, 4.0, 8.0]},
    ),
    CatalogueEntry(
        "fast_moves",
        "fast moves near the limits of speed and torque: saturation, inertia and delay",
        lambda _: {"diagnosis.parts": ["moves", "steps"], "diagnosis.intensity": 1.2},
    ),
    CatalogueEntry(
        "soft_controller",
        "the diagnosis experiment with a softer controller: what changes with the feedback is told from what does not",
        _soft,
    ),
    CatalogueEntry(
        "known_payload",
        "mount a known load of half the last body, write it into the robot file and repeat: inertia and torque gain "
        "part, since only the ratio of both was seen",
        _loaded,
    ),
    CatalogueEntry(
        "tool_measurement",
        "measure the tool position in the diagnosis experiment: motors alone do not show what the arm does behind them",
        lambda _: {},
        tool=True,
    ),
)
"""The experiments, those first that cost the user least."""
