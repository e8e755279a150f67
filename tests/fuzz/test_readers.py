"""Damaged and made-up inputs for everything that reads what others wrote: read, or refused in one sentence."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tests.fuzz.readers import READERS, outcome

CHECKS = settings(
    max_examples=30,
    derandomize=True,
    deadline=None,
    database=None,
    phases=[Phase.explicit, Phase.generate, Phase.shrink],
    suppress_health_check=list(HealthCheck),
)
"""Few inputs, the same each time; `make fuzz` tries many."""


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
@CHECKS
@given(data=st.data())
def test_input_is_read_or_refused(name: str, data: st.DataObject) -> None:
    assert outcome(READERS[name], data.draw(READERS[name].inputs)) in ("read", "refused")
