"""Settings of a diagnosis: all are described and validated, and they decide."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from flexros.config.settings import Settings
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.search.model_probability import compare
from flexros.gap.settings import DiagnosisSettings, FitSettings, RankingSettings
from tests.gap.diagnosis_logs import MODEL, data_of


def groups(settings: type[Settings] = DiagnosisSettings) -> list[type[Settings]]:
    """List a group with the groups in it."""
    inner = [getattr(settings(), name) for name in settings.model_fields]
    return [settings, *(group for value in inner if isinstance(value, Settings) for group in groups(type(value)))]


@pytest.mark.parametrize("group", groups(), ids=lambda group: group.__name__)
def test_every_setting_is_described(group: type[Settings]) -> None:
    assert [name for name, field in group.model_fields.items() if not field.description] == []


def test_unknown_keys_and_impossible_values_are_refused() -> None:
    with pytest.raises(ValidationError, match="rivals"):
        RankingSettings(rivals=3.0)  # type: ignore[call-arg]
    with pytest.raises(ValidationError, match="most_starts"):
        FitSettings(most_starts=0)


def test_settings_decide_what_is_significant() -> None:
    data = data_of("coulomb_friction@motor_1:level=0.05")
    null = fit_null(data, MODEL, Tolerance()).fit
    assert compare(data, null).significant(null)
    assert not compare(data, null, settings=RankingSettings(significant=1e6)).significant(null)
