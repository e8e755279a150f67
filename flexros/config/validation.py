"""Turning what a user wrote into a validated object, or into one clear sentence."""

from __future__ import annotations

from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

Model = TypeVar("Model", bound=BaseModel)


class Settings(BaseModel):
    """Base of everything a user writes in YAML: frozen, no unknown keys, no infinite or NaN numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True)


def validate(model: type[Model], data: Mapping[str, Any], source: str) -> Model:
    """Validate data against a settings class.

    Args:
        model: Class to build.
        data: What the user gave.
        source: Where it came from, e.g. a file name; opens the error text.

    Returns:
        The validated object.

    Raises:
        InputError: The first problem, with source, key, value given and value allowed.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise InputError(_sentence(model, error, source)) from error


def _sentence(model: type[BaseModel], error: ValidationError, source: str) -> str:
    """Say the most telling of the problems found: of a union's branches the one that got deepest."""
    problems = error.errors(include_url=False)
    first = problems[0]["loc"][:1]
    problem = max((p for p in problems if p["loc"][:1] == first), key=lambda p: len(p["loc"]))
    key = _key(problem["loc"])
    given = problem.get("input")
    if problem["type"] == "extra_forbidden":
        allowed = _allowed_keys(model, problem["loc"])
        nearest = get_close_matches(str(problem["loc"][-1]), allowed, n=1)
        hint = f"did you mean '{nearest[0]}'? " if nearest else ""
        listing = f"allowed are {', '.join(allowed)}" if allowed else "it is not a known key"
        return f"{source}: unknown key '{key}': {hint}{listing}"
    if problem["type"] == "missing":
        return f"{source}: key '{key}' is missing; add it"
    if problem["type"] in ("value_error", "assertion_error"):
        return f"{source}: {f'key {key!r}: ' if key else ''}{problem['ctx']['error']}"
    text = problem["msg"][0].lower() + problem["msg"][1:]
    return f"{source}: key '{key}' is {_short(given)}, but {text}; correct the value"


def _key(location: tuple[int | str, ...]) -> str:
    """Write a place in nested data the way it is read: bodies[0].mass."""
    text = ""
    for part in location:
        if isinstance(part, int):
            text += f"[{part}]"
        elif "(" not in part:  # pydantic names validators and union branches in the location; a user knows only keys
            text += f".{part}" if text else part
    return text


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _allowed_keys(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """List the keys allowed beside an unknown one, following the location through the nested models."""
    current: Any = model
    for part in location[:-1]:
        fields = getattr(current, "model_fields", None)
        if fields is not None and part in fields:
            current = fields[part].annotation
        current = _model_within(current, part)
        if current is None:
            return []
    return list(getattr(current, "model_fields", {}))


def _model_within(annotation: Any, part: int | str) -> Any:
    """Find the settings class inside list[...], dict[...], X | None or a union; None when there is none."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    candidates = [_model_within(inner, part) for inner in getattr(annotation, "__args__", ())]
    named = [c for c in candidates if c is not None]
    tagged = [c for c in named if c.__name__ == part]
    return (tagged or named or [None])[0]
