"""Parts of a robot file that are not written where they are absent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import SerializerFunctionWrapHandler, model_serializer

from flexros.config.settings import Settings
from flexros.robot.quantity import Quantity


class SparseSettings(Settings):
    """Settings that leave out keys without meaning, so that the fingerprints of robots without them remain."""

    absent: ClassVar[Mapping[str, Any]]
    """The keys that are left out, and the value of each that means nothing; that of a quantity is its number."""

    @model_serializer(mode="wrap")
    def _without_absent_keys(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = handler(self)
        return {key: value for key, value in data.items() if key not in self.absent or self._given(key)}

    def _given(self, key: str) -> bool:
        given = getattr(self, key)
        return bool((given.value if isinstance(given, Quantity) else given) != self.absent[key])
