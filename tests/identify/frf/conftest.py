"""A log that is recorded once and spoilt in many ways."""

from __future__ import annotations

import pytest

from tests.identify.frf.recorded_experiment import Recorded, run


@pytest.fixture(scope="session")
def recorded() -> Recorded:
    """Give the log of periodic excitation."""
    return run()
