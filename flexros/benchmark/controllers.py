"""Controllers of the benchmark: built-in ones, and files of users."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import Field

from flexros.config.settings import Settings, validate
from flexros.config.yaml_file import read_yaml
from flexros.control.base import AbstractControlLaw, control_law
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Mapping

_FOLDER = Path(__file__).parent / "library"


@dataclass(frozen=True)
class BenchmarkController:
    """The two controllers of a design: C1 for the nominal model, C2 for the perturbed ones (Paper C, section 5.4).

    Attributes:
        name: Name of the design.
        nominal: Control law C1 of the nominal model.
        perturbed: Control law C2 of the model sets M1 and M2; one set of values for all of them.
        description: What it is and where it comes from.
        sensors: Sensors that it uses beside the motor encoder.
    """

    name: str
    nominal: AbstractControlLaw
    perturbed: AbstractControlLaw
    description: str = ""
    sensors: tuple[str, ...] = ()


class ControllerFile(Settings):
    """A controller file: one controller for all models, or one for the nominal and one for the perturbed models."""

    description: str = Field(default="", description="what the design is and where it comes from")
    made_by: str = Field(default="", description="command that reproduces the file")
    parameters: dict[str, dict[str, float]] = Field(
        default_factory=dict, description="numbers from which the laws were made, by nominal and perturbed"
    )
    sensors: tuple[str, ...] = Field(default=(), description="sensors besides the motor encoder: tool_acceleration")
    controller: dict[str, Any] | None = Field(default=None, description="kind and settings for all models")
    nominal: dict[str, Any] | None = Field(default=None, description="kind and settings for the nominal model (C1)")
    perturbed: dict[str, Any] | None = Field(default=None, description="kind and settings for the sets M1 and M2 (C2)")


def controller_names() -> tuple[str, ...]:
    """Return the names of the built-in controllers of the benchmark."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


def load_controller(name_or_path: str | Path) -> BenchmarkController:
    """Load a controller for the benchmark.

    Args:
        name_or_path: Built-in name; path of a YAML file with the keys of `ControllerFile`, or with `kind` and the
            settings of one control law; or path of a Python file that defines one control law.

    Raises:
        InputError: Unknown name, malformed file, or invalid setting; names file and key.
    """
    text = str(name_or_path)
    if text in controller_names():
        return _from_yaml(_FOLDER / f"{text}.yaml")
    path = Path(name_or_path)
    if path.suffix == ".py":
        law = _law_of_python(path, {})
        return BenchmarkController(path.stem, law, law, f"Python law of {path.name}")
    if path.suffix in (".yaml", ".yml") or "/" in text:
        return _from_yaml(path)
    raise unknown_name("controller", text, controller_names(), other="or the path of a .yaml or .py file")


def read_parameters(name_or_path: str | Path) -> dict[str, dict[str, float]]:
    """Return the numbers from which the laws of a controller file were made, by nominal and perturbed.

    Args:
        name_or_path: Built-in name, or path of a controller file.

    Raises:
        InputError: The file cannot be read.
    """
    return _file(name_or_path).parameters


def read_made_by(name_or_path: str | Path) -> str:
    """Return the command that reproduces a controller file, empty for none.

    Args:
        name_or_path: Built-in name, or path of a controller file.

    Raises:
        InputError: The file cannot be read.
    """
    return _file(name_or_path).made_by


def _file(name_or_path: str | Path) -> ControllerFile:
    text = str(name_or_path)
    path = _FOLDER / f"{text}.yaml" if text in controller_names() else Path(name_or_path)
    return validate(ControllerFile, read_yaml(path), str(path))


def _from_yaml(path: Path) -> BenchmarkController:
    content = read_yaml(path)
    if "kind" in content or "python" in content:
        sensors = content.pop("sensors", ())
        content = {"controller": content, "sensors": sensors}
    file = validate(ControllerFile, content, str(path))
    if (file.controller is None) == (file.nominal is None) or (file.nominal is None) != (file.perturbed is None):
        given = [key for key in ("controller", "nominal", "perturbed") if getattr(file, key) is not None]
        raise InputError(
            f"{path}: the keys {', '.join(given) or 'controller, nominal, perturbed'} "
            f"{'are given together' if given else 'are missing'}, allowed is either controller alone or nominal with "
            "perturbed; correct the file"
        )
    settings = {
        key: value
        for key, value in (
            ("nominal", file.nominal or file.controller),
            ("perturbed", file.perturbed or file.controller),
        )
        if value is not None
    }
    laws = {key: _law(value, path, key if file.controller is None else "controller") for key, value in settings.items()}
    return BenchmarkController(path.stem, laws["nominal"], laws["perturbed"], file.description, file.sensors)


def _law(settings: Mapping[str, Any], path: Path, key: str) -> AbstractControlLaw:
    """Build a law from its settings; a relative file is looked for beside the controller file."""
    given = dict(settings)
    source = f"{path}, key {key}"
    for name in ("file", "python"):
        if isinstance(given.get(name), str):
            given[name] = str(path.parent / given[name])
    if "python" in given:
        return _law_of_python(Path(given.pop("python")), given, source)
    return control_law(given, source)


def _law_of_python(path: Path, settings: Mapping[str, Any], source: str = "") -> AbstractControlLaw:
    """Run a Python file of the user and build the only control law that it defines."""
    origin = source or str(path)
    if not path.is_file():
        raise InputError(f"{origin}: the Python file '{path}' does not exist; give the path of a control law")
    name = f"flexros_user_law_{path.stem}_{abs(hash(str(path.resolve()))):x}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module  # pydantic resolves annotations there
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            del sys.modules[name]
            raise InputError(f"{origin}: '{path}' fails with {type(error).__name__}: {error}; correct it") from error
    module = sys.modules[name]
    laws = [
        member
        for member in vars(module).values()
        if inspect.isclass(member)
        and issubclass(member, AbstractControlLaw)
        and not inspect.isabstract(member)
        and member.__module__ == name
    ]
    if len(laws) != 1:
        raise InputError(
            f"{origin}: '{path}' defines {len(laws)} control laws, allowed is one final subclass of "
            "flexros.control.base.AbstractControlLaw; correct the file"
        )
    return validate(laws[0], dict(settings), origin)
