"""A scenario: the complete, validated and frozen description of one run."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, PlainSerializer, model_validator
from pydantic_core import PydanticKnownError

from flexros.config.settings import Settings, validate
from flexros.config.text_file import is_file
from flexros.config.yaml_file import read_yaml
from flexros.control.base import AbstractControlLaw, control_law
from flexros.effects import parse_effect
from flexros.errors import InputError, unknown_name
from flexros.feedforward.specification import FeedforwardSpecification
from flexros.identify.diagnosis_experiment.specification import DiagnosisSpecification
from flexros.identify.experiment.specification import IdentificationSpecification
from flexros.simulate.disturbance import Disturbance
from flexros.trajectory import TrajectorySpecification

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


_FOLDER = Path(__file__).parent / "library"


def _designed_controller(given: dict[str, Any]) -> Any:
    """Design the controller of a diagnosis experiment without one; return None otherwise, which is refused."""
    if given.get("diagnosis") is None:
        return None
    from flexros.effects.patching.patched_robot import load_patched
    from flexros.identify.design.default_controller import default_controller

    robot = load_patched(given["robot"]).with_values(given["model"].values, "model.values").base
    return default_controller(robot, given["sample_time"] or robot.sample_time)


def _control_law(given: Any) -> Any:
    """Build the control law by its kind; its error becomes part of the scenario's."""
    if given is None:
        raise PydanticKnownError("missing")
    if isinstance(given, AbstractControlLaw):
        return given
    if not isinstance(given, dict):
        raise ValueError(f"is {given!r}, but must be a mapping with the key kind and the settings of that controller")
    try:
        return control_law(given, "controller")
    except InputError as error:
        raise ValueError(str(error)) from error


def _as_mapping(law: AbstractControlLaw) -> dict[str, Any]:
    return {"kind": law.kind, **law.model_dump(mode="json")}


ControlLaw: TypeAlias = Annotated[AbstractControlLaw, BeforeValidator(_control_law), PlainSerializer(_as_mapping)]


def _finite(values: dict[str, float]) -> dict[str, float]:
    for name, value in values.items():
        if not math.isfinite(value):
            raise ValueError(f"{name} is {value}, but must be a finite number")
    return values


Values: TypeAlias = Annotated[dict[str, float], AfterValidator(_finite)]


class ModelSettings(Settings):
    """Deviations of a robot from its file."""

    values: Values = Field(
        default_factory=dict,
        description="values of the robot file to replace, e.g. {body_3.mass: 190}, each in the unit of the file",
    )


def _effect(text: str) -> str:
    """Refuse a malformed effect; its location is checked on the robot."""
    try:
        parse_effect(text, "effect")
    except InputError as error:
        raise ValueError(str(error)) from error
    return text


EffectText: TypeAlias = Annotated[str, AfterValidator(_effect)]
"""An effect as written on the command line, NAME@LOCATION:parameter=value,..."""


class PlantSettings(ModelSettings):
    """Deviations of the simulated robot from the nominal one."""

    effects: tuple[EffectText, ...] = Field(
        default=(),
        description="effects applied in order after the values, each as NAME@LOCATION:parameter=value,... (units of "
        "the effect), e.g. payload_error@tool:relative=0.05",
    )


class Scenario(Settings):
    """Complete description of one run.

    The feedforward uses the nominal robot, with the effects of a patch if `robot` names one, unless
    `feedforward_model` names another model. The plant is the nominal robot with additional deviations.
    """

    name: str = Field(
        default="",
        pattern=r"^[\w.+ -]*$",
        max_length=100,
        description="name of the run, part of file names; default: the file's name",
    )
    description: str = Field(
        default="", description="purpose of the scenario, and which values are published or chosen"
    )
    robot: str = Field(
        description="built-in robot, or path of a robot file or of a patch, relative to the scenario's folder"
    )
    model: ModelSettings = Field(
        default_factory=ModelSettings, description="deviations of the nominal robot from its file, also in the plant"
    )
    plant: PlantSettings = Field(
        default_factory=PlantSettings, description="deviations of the simulated robot from the nominal one"
    )
    sample_time: float | None = Field(
        default=None, gt=0.0, le=1.0, description="time between two samples [s]; default: that of the robot"
    )
    substeps: int = Field(default=1, ge=1, le=1000, description="integration steps of the plant in a sample [1]")
    start: tuple[float, ...] | None = Field(
        default=None, description="initial arm coordinates [rad or m]; default: home of the robot"
    )
    trajectory: TrajectorySpecification | None = Field(
        default=None, description="path and time law of the controlled output; default: hold the start"
    )
    identification: IdentificationSpecification | None = Field(
        default=None,
        description="positions, excitation and periods of an identification experiment, instead of a trajectory",
    )
    diagnosis: DiagnosisSpecification | None = Field(
        default=None, description="length, parts and sizes of a diagnosis experiment, instead of a trajectory"
    )
    feedforward: FeedforwardSpecification = Field(
        default_factory=FeedforwardSpecification, description="method that computes motor references and torques"
    )
    feedforward_model: str | None = Field(
        default=None,
        description="robot file or patch that the feedforward uses instead of the nominal robot, e.g. the patch of a "
        "diagnosis; relative to the scenario's folder; the plant is unaffected",
    )
    feedforward_torque: bool = Field(
        default=True,
        description="whether the feedforward torque is applied; false: only its motor positions are followed",
    )
    controller: ControlLaw = Field(
        default_factory=_designed_controller,
        description="kind and settings of the feedback controller; default for a diagnosis: designed for the robot",
    )
    disturbances: tuple[Disturbance, ...] = Field(
        default=(), description="torques that the plant adds at motors and tool"
    )
    noise: bool = Field(default=True, description="whether the sensors have the noise of the robot file")
    seed: int = Field(default=1, ge=0, lt=2**63, description="seed of sensor noise and random disturbances [1]")
    duration: float | None = Field(
        default=None, gt=0.0, description="length of the run [s]; default: that of the trajectory with its holds"
    )

    @model_validator(mode="after")
    def _has_an_end(self) -> Scenario:
        leader = next((key for key in ("identification", "diagnosis") if getattr(self, key) is not None), "")
        if leader:
            for key in ("trajectory", "duration", "diagnosis"):
                if key != leader and getattr(self, key) is not None:
                    raise ValueError(
                        f"the scenario has {leader} and {key}, allowed is one of them, because {leader} "
                        f"determines motion and duration; remove {key}"
                    )
        elif self.trajectory is None and self.duration is None:
            raise ValueError("the scenario has neither trajectory nor duration; add duration in s")
        return self

    def settings(self) -> dict[str, Any]:
        """Return the keys that were set as plain data, from which `Scenario(**...)` builds the scenario again."""
        return self.model_dump(mode="json", exclude_unset=True)

    def with_values(self, values: Mapping[str, Any], source: str = "") -> Scenario:
        """Return a copy with some keys changed.

        Args:
            values: Dotted key -> new value, e.g. {"sample_time": 0.001, "plant.values.body_3.mass": 190,
                "disturbances.0.amplitude": 5}.
            source: Origin of the values, for error messages; default: the scenario's name.

        Raises:
            InputError: Unknown key or invalid value.
        """
        origin = source or f"scenario {self.name}"
        settings = self.settings()
        for key, value in values.items():
            _set(settings, key.split("."), value, f"{origin}, key {key}")
        return validate(Scenario, settings, origin)

    def with_choices(
        self,
        robot: str | None = None,
        settings: Mapping[str, Any] | None = None,
        effects: Sequence[str] = (),
        seed: int | None = None,
        *,
        sources: tuple[str, str] = ("given settings", "given effects"),
    ) -> Scenario:
        """Return a copy with what was chosen for one run.

        Args:
            robot: Robot instead of the scenario's, also of one among the settings.
            settings: Dotted key -> new value, as in `with_values`.
            effects: Effects in the plant, after those of the scenario.
            seed: Seed instead of the scenario's, also of one among the settings.
            sources: Origins of the settings and of the effects, for error messages.

        Raises:
            InputError: Unknown key or invalid value.
        """
        own = {key: value for key, value in (("robot", robot), ("seed", seed)) if value is not None}
        changes = {**(settings or {}), **own}
        changed = self.with_values(changes, sources[0]) if changes else self
        further = {"plant.effects": [*changed.plant.effects, *effects]}
        return changed.with_values(further, sources[1]) if effects else changed

    def digest(self) -> str:
        """Return the SHA-256 of everything that determines the run, as sorted JSON without name and description."""
        settings = self.model_dump(mode="json", exclude={"name", "description"})
        if not self.plant.effects:  # scenarios without effects keep the hash from before this key existed
            del settings["plant"]["effects"]
        for key in ("identification", "diagnosis", "feedforward_model"):
            if settings[key] is None:
                del settings[key]
        return hashlib.sha256(json.dumps(settings, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def scenario_names() -> tuple[str, ...]:
    """Return the names of the built-in scenarios."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Load a scenario.

    Args:
        name_or_path: Built-in name, or path of a YAML file. Relative paths of robot and feedforward model in the file
            are relative to its folder.

    Raises:
        InputError: Unknown scenario, malformed YAML, unknown key or invalid value; names file and key.
    """
    path = _path(name_or_path)
    settings = {"name": path.stem, **read_yaml(path)}
    for key in ("robot", "feedforward_model"):
        robot = settings.get(key)
        if isinstance(robot, str) and robot.endswith((".yaml", ".yml")) and is_file(path.parent / robot):
            settings[key] = str(path.parent / robot)
    return validate(Scenario, settings, str(path))


def _path(name_or_path: str | Path) -> Path:
    text = str(name_or_path)
    if text in scenario_names():
        return _FOLDER / f"{text}.yaml"
    if isinstance(name_or_path, Path) or text.endswith((".yaml", ".yml")) or "/" in text:
        return Path(name_or_path)
    raise unknown_name("scenario", text, scenario_names(), other="or the path of a .yaml file")


def _set(container: Any, keys: list[str], value: Any, source: str) -> None:
    """Set a value in nested plain data; below `values` the rest of the key is one name with dots."""
    key, rest = keys[0], keys[1:]
    if isinstance(container, list):
        if not key.isdigit() or int(key) >= len(container):
            allowed = f"0 to {len(container) - 1}" if container else "none, the list is empty"
            raise InputError(f"{source}: there is no entry {key}, allowed are {allowed}; add the entry to the scenario")
        if rest:
            _set(container[int(key)], rest, value, source)
        else:
            container[int(key)] = value
    elif not isinstance(container, dict):
        raise InputError(f"{source}: '{key}' is within {container!r}, which has no keys; give a key that exists")
    elif not rest:
        container[key] = value
    elif key == "values":
        container.setdefault(key, {})[".".join(rest)] = value
    else:
        if container.get(key) is None:
            container[key] = [] if rest[0].isdigit() else {}
        _set(container[key], rest, value, source)
