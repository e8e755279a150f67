"""The robots of a scenario: as the feedforward knows it, and as it is simulated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.effects import RobotWithEffects, parse_effect, place_effects
from flexros.effects.patched_robot import fingerprint, load_patched
from flexros.errors import InputError, source_named

if TYPE_CHECKING:
    from flexros.config.scenario import Scenario
    from flexros.effects.patched_robot import PatchedRobot
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class ScenarioModels:
    """The robots of a scenario.

    Attributes:
        nominal: The robot that the scenario names, with the effects of a patch, if it names one.
        known: What the feedforward believes in: the nominal one, or that of the key `feedforward_model`.
        plant: What is simulated: the nominal one with the deviations of the plant on top.
    """

    nominal: RobotWithEffects
    known: RobotWithEffects
    plant: RobotWithEffects

    @classmethod
    def of(cls, scenario: Scenario) -> ScenarioModels:
        """Load the robots of a scenario.

        Args:
            scenario: The scenario.

        Returns:
            The robots. Values replace numbers of the robot file; effects come on top of all values: first those of
            the patch, then those of the plant.

        Raises:
            InputError: A robot cannot be loaded, or has no such number or place; names scenario and key.
        """
        source = f"scenario {scenario.name}"
        nominal = load_patched(scenario.robot).with_values(scenario.model.values, f"{source}, key model.values")
        plant, known = _plant(scenario, nominal, source), nominal.model
        if scenario.feedforward_model is not None:
            known = _known(scenario, known, source)
        return cls(nominal.model, known, plant)

    def fingerprints(self) -> dict[str, str]:
        """Give the fingerprints of the robots for the provenance of a run; that of `known` where it is another one."""
        names = {"model_hash": self.nominal, "plant_hash": self.plant}
        if self.known is not self.nominal:
            names["feedforward_hash"] = self.known
        return {name: fingerprint(model.robot, model.laws) for name, model in names.items()}


def _plant(scenario: Scenario, nominal: PatchedRobot, source: str) -> RobotWithEffects:
    """Change the robot by the plant's values, then by the effects of the patch and of the plant."""
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


def _known(scenario: Scenario, nominal: RobotWithEffects, source: str) -> RobotWithEffects:
    """Load what the feedforward believes in, a robot of the same coordinates."""
    key = f"{source}, key feedforward_model"
    with source_named(key):
        known = load_patched(scenario.feedforward_model or "")
        known = known.with_values(scenario.model.values, f"{key}, with model.values")
    ours, theirs = (robot.spec.coordinates + "".join(robot.joint_names) for robot in (nominal.robot, known.base))
    if ours != theirs:
        raise InputError(
            f"{key}: robot {_described(known.base)}, but the scenario's robot {_described(nominal.robot)}; give a "
            "model of the same robot"
        )
    return known.model


def _described(robot: Robot) -> str:
    return f"{robot.name} has {robot.n_motors} motors, stated on the {robot.spec.coordinates} side of the gear"
