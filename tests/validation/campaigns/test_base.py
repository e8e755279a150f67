"""Campaigns are found by their names."""

from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.validation.campaigns.base import campaign_named, campaigns


def test_campaigns_are_found() -> None:
    assert {"coverage", "path_improvement"} <= set(campaigns())


@pytest.mark.parametrize("name", list(campaigns()))
def test_every_campaign_says_what_it_answers(name: str) -> None:
    campaign = campaign_named(name)
    assert campaign.name == name
    assert campaign.question.endswith("?")


def test_unknown_campaign_is_named() -> None:
    with pytest.raises(InputError, match="unknown campaign 'coverag' in the command line: did you mean 'coverage'"):
        campaign_named("coverag", "the command line")
