"""Variations of numeric settings, for any settings model with nested groups."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from flexros.config.settings import Settings, validate

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

Model = TypeVar("Model", bound=Settings)


def numeric_keys(settings: Settings, left_out: tuple[str, ...] = ()) -> dict[str, Any]:
    """List the numeric settings of a model and of its groups.

    Args:
        settings: The model.
        left_out: Names of settings or groups at the top level that are skipped.

    Returns:
        Values by dotted name: numbers that are not zero, and tuples of numbers; switches and texts are skipped.
    """
    content = {key: value for key, value in settings.model_dump().items() if key not in left_out}
    return dict(_numbers(content))


def varied(settings: Model, key: str, factor: float) -> Model:
    """Multiply one setting.

    Args:
        settings: The model with the defaults.
        key: Dotted name of the setting.
        factor: Factor on its value [1]; whole numbers are rounded.

    Returns:
        The model with the new value.

    Raises:
        InputError: The new value is not allowed.
    """
    content = settings.model_dump()
    group = content
    *groups, name = key.split(".")
    for part in groups:
        group = group[part]
    group[name] = scaled(group[name], factor)
    return validate(type(settings), content, f"{key} times {factor:g}")


def scaled(value: Any, factor: float) -> Any:
    """Multiply a number, or each of a tuple; whole numbers stay whole."""
    if isinstance(value, tuple):
        return tuple(scaled(entry, factor) for entry in value)
    return round(value * factor) if isinstance(value, int) else value * factor


def _numbers(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in content.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from _numbers(value, f"{name}.")
        elif _is_number(value) or (isinstance(value, tuple) and value and all(map(_is_number, value))):
            yield name, value


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value != 0
