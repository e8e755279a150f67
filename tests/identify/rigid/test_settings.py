"""Settings of the rigid regression."""

from __future__ import annotations

import pytest

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.identify.rigid.settings import RigidSettings


def test_cutoff_follows_the_rate_unless_given() -> None:
    assert RigidSettings().cutoff_at(500.0) == 50.0
    assert RigidSettings().cutoff_at(2000.0) == 100.0
    assert RigidSettings(cutoff=7.0).cutoff_at(2000.0) == 7.0


def test_cutoff_must_be_positive() -> None:
    with pytest.raises(InputError, match="key 'cutoff' is -1"):
        validate(RigidSettings, {"cutoff": -1}, "settings")
