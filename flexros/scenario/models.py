"""The models of a scenario: nominal robot, robot of the feedforward, simulated robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.effects.patching.patched_robot import fingerprint, load_patched
from flexros.errors import InputError, source_named

if TYPE_CHECKING:
    from flexros.effects import PlacedEffect
    from flexros.effects.patching.patched_robot import PatchedRobot
    from flexros.robot import Robot
    from flexros.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class ScenarioModels:
    """The models of a scenario.

    Attributes:
        nominal: The robot of the scenario, with the effects of a patch if it names one.
        known: Model of the feedforward: the nominal one, or that of the key `feedforward_model`.
        plant: The simulated robot: the nominal one with the deviations of the plant.
        nominal_effects: Effects of the patch named by the key `robot`.
        known_effects: Effects of the patch named by the key `feedforward_model`.
    """

    nominal: RobotWithEffects
    known: RobotWithEffects
    plant: RobotWithEffects
    nominal_effects: tuple[PlacedEffect, ...] = ()
    known_effects: tuple[PlacedEffect, ...] = ()

    @classmethod
    def of(cls, scenario: Scenario) -> ScenarioModels:
        """Load the models of a scenario.

        Values replace those of the robot file. Effects are applied to the result: first those of the patch, then
        those of the plant.

        Raises:
            InputError: A robot cannot be loaded, or has no such parameter or location; names scenario and key.
        """
        source = f"scenario {scenario.name}"
        nominal = load_patched(scenario.robot).with_values(scenario.model.values, f"{source}, key model.values")
        plant = _plant(scenario, nominal, source)
        if scenario.feedforward_model is None:
            return cls(nominal.model, nominal.model, plant, nominal.placed)
        known = _known(scenario, scenario.feedforward_model, nominal.base, source)
        return cls(nominal.model, known.model, plant, nominal.placed, known.placed)

    def provenance(self) -> dict[str, Any]:
        """Return fingerprints of the models and effects of patches for the provenance of a run."""
        content: dict[str, Any] = {"model_hash": self._hash(self.nominal), "plant_hash": self._hash(self.plant)}
        if self.known is not self.nominal:
            content["feedforward_hash"] = self._hash(self.known)
        for key, placed in (("model_effects", self.nominal_effects), ("feedforward_effects", self.known_effects)):
            if placed:
                content[key] = [str(effect) for effect in placed]
        return content

    @staticmethod
    def _hash(model: RobotWithEffects) -> str:
        return fingerprint(model.robot, model.laws)


def _plant(scenario: Scenario, nominal: PatchedRobot, source: str) -> RobotWithEffects:
    """Apply the plant's values, then the effects of the patch and of the plant."""
    key = f"{source}, key plant"
    if "sample_time" in scenario.plant.values:
        raise InputError(
            f"{key}.values: sample_time is given, but plant and controller share one sample time; set the scenario's "
            "key sample_time instead"
        )
    plant = nominal.with_values(scenario.plant.values, f"{key}.values")
    with source_named(f"{key}.effects"):
        hidden = [parse_effect(text, "effect") for text in scenario.plant.effects]
        return place_effects(plant.base, [*plant.placed, *hidden])


def _known(scenario: Scenario, name: str, nominal: Robot, source: str) -> PatchedRobot:
    """Load the model of the feedforward and check that it describes the same robot."""
    key = f"{source}, key feedforward_model"
    with source_named(key):
        known = load_patched(name).with_values(scenario.model.values, "model.values of the scenario")
    ours, theirs = ((robot.spec.coordinates, robot.n_motors) for robot in (nominal, known.base))
    if ours != theirs:
        raise InputError(
            f"{key}: robot {_described(known.base)}, but the scenario's robot {_described(nominal)}; give a model of "
            "the same robot"
        )
    return known


def _described(robot: Robot) -> str:
    count = f"{robot.n_motors} motor{'s' * (robot.n_motors != 1)}"
    return f"{robot.name} has {count}, stated on the {robot.spec.coordinates} side of the gear"
