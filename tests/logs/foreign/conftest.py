"""Small foreign logs that the tests of this room share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.config.settings import validate
from flexros.logs.foreign.mapping import LogMapping


def mapping_of(*columns: dict[str, Any], **keys: Any) -> LogMapping:
    """Validate a mapping; without columns one of a position in rad."""
    listed = list(columns) or [{"column": "q", "quantity": "position", "unit": "rad"}]
    return validate(LogMapping, {"name": "mine", "time": {"column": "t"}, "columns": listed, **keys}, "mine.yaml")


def table_of(n: int = 50) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(3)
    return {"t": np.arange(n) * 1e-3, "q": rng.normal(size=n), "u": rng.normal(size=n), "r": rng.normal(size=n)}


def write_csv(path: Path, columns: dict[str, np.ndarray]) -> Path:
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(repr(float(value)) for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(name="mapping_of")
def mapping_of_fixture():
    return mapping_of


@pytest.fixture
def table():
    return table_of()


@pytest.fixture(name="write_csv")
def write_csv_fixture():
    return write_csv
