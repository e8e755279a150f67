"""Validation of user data against settings classes, with one clear error message."""

from __future__ import annotations

from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pydantic.fields import FieldInfo

Model = TypeVar("Model", bound=BaseModel)


class Settings(BaseModel):
    """Base of all settings that users write in YAML: frozen, no unknown keys, finite numbers only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True)


def validate(model: type[Model], data: Mapping[str, Any], source: str) -> Model:
    """Validate data against a settings class.

    Args:
        model: Class to build.
        data: Data of the user.
        source: Origin of the data, e.g. a file name; prefix of the error message.

    Raises:
        InputError: The first problem, with source, key, given value and allowed values.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise InputError(_sentence(model, error, source, data)) from error


def _sentence(model: type[BaseModel], error: ValidationError, source: str, data: Mapping[str, Any]) -> str:
    """Return the message of the most specific problem: of a union's branches the one that got deepest."""
    problems = error.errors(include_url=False)
    problems.sort(key=lambda problem: problem["type"] != "extra_forbidden")  # a misspelt key explains a missing one
    first = problems[0]["loc"][:1]
    problem = max((p for p in problems if p["loc"][:1] == first), key=lambda p: len(p["loc"]))
    key = _key(problem["loc"], data)
    given = problem.get("input")
    if problem["type"] == "extra_forbidden":
        fields = _fields_at(model, problem["loc"])
        unknown, allowed = str(problem["loc"][-1]), list(fields)
        nearest = get_close_matches(unknown, allowed, n=1)
        hint = f"did you mean '{nearest[0]}'? " if nearest else _hint_of_a_number(unknown, given, fields)
        listing = f"allowed are {', '.join(allowed)}" if allowed else "it is not a known key"
        return f"{source}: unknown key '{key}': {hint}{listing}"
    if problem["type"] == "missing":
        return f"{source}: key '{key}' is missing; add it"
    if problem["type"] in ("value_error", "assertion_error"):
        return f"{source}: {f'key {key!r}: ' if key else ''}{problem['ctx']['error']}"
    text = problem["msg"][0].lower() + problem["msg"][1:]
    return f"{source}: key '{key}' is {_short(given)}, but {text}; correct the value"


def _key(location: tuple[int | str, ...], data: Any) -> str:
    """Format a location in nested data as a key: bodies[0].mass.

    Pydantic includes validators and branches of unions in the location; only parts that are in the data are keys.
    """
    text = ""
    for depth, part in enumerate(location):
        inside = isinstance(data, dict) and part in data
        if isinstance(part, int) and isinstance(data, (list, tuple)) and part < len(data):
            text, data = f"{text}[{part}]", data[part]
        elif inside or (depth == len(location) - 1 and isinstance(data, dict)):
            text, data = f"{text}.{part}" if text else str(part), data.get(part)
    return text


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _hint_of_a_number(unknown: str, given: object, fields: Mapping[str, FieldInfo]) -> str:
    """Say where a key belongs that a number beside it has; empty where none has it."""
    for name, field in fields.items():
        if any({"value", unknown} <= inner.model_fields.keys() for inner in _models_within(field.annotation)):
            return f"that of a number is written {name}: {{value: ..., {unknown}: {_short(given)}}}; "
    return ""


def _fields_at(model: type[BaseModel], location: tuple[int | str, ...]) -> Mapping[str, FieldInfo]:
    """Return the fields of which one is allowed in place of an unknown key, following its location."""
    candidates = [model]
    for part in location[:-1]:
        tagged = [candidate for candidate in candidates if part in (candidate.__name__, *_tags(candidate))]
        holding = [candidate for candidate in candidates if part in candidate.model_fields]
        if tagged:
            candidates = tagged
        elif holding:
            candidates = _models_within(holding[0].model_fields[str(part)].annotation)
    return candidates[0].model_fields if candidates else {}


def _models_within(annotation: Any) -> list[type[BaseModel]]:
    """Return the settings classes inside list[...], dict[...], X | None or a union."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for inner in getattr(annotation, "__args__", ()) for model in _models_within(inner)]


def _tags(model: type[BaseModel]) -> tuple[Any, ...]:
    """Return the words that select a branch of a discriminated union."""
    fields = [model.model_fields[key] for key in ("type", "kind") if key in model.model_fields]
    return tuple(word for field in fields for word in getattr(field.annotation, "__args__", ()))
