"""Campaign: does the proposed experiment separate effects that a log could not separate?"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, ClassVar

from flexros.validation.campaigns.base import AbstractCampaign, CampaignResult
from flexros.validation.campaigns.hard_pairs.settings import HardPairsSettings
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of

if TYPE_CHECKING:
    from flexros.validation.campaigns.base import CampaignRequest

PAGE, FIGURES = "hard_pairs.md", "data/hard_pairs.json"


class HardPairs(AbstractCampaign):
    """Short logs of effects that imitate each other, and the experiments that the diagnosis proposes.

    Args:
        settings: Pairs, sizes and logs.
    """

    name: ClassVar[str] = "hard_pairs"
    question: ClassVar[str] = "Does the proposed experiment separate effects that a log could not separate?"

    def __init__(self, settings: HardPairsSettings | None = None) -> None:
        self._settings = settings or HardPairsSettings()

    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it; see `AbstractCampaign.run`."""
        from flexros.json_text import json_text
        from flexros.validation.campaigns.hard_pairs.page import pairs_page, pairs_summary
        from flexros.validation.campaigns.hard_pairs.pair_part import pair_part

        settings = self._settings
        claim_folder(request.work, asdict(settings))
        truths = [truth for pair in settings.pairs.values() for truth in pair]
        parts = finished_parts(
            request.work,
            request.client,
            {f"truth_{number:02d}": (settings, truth) for number, truth in enumerate(truths)},
            pair_part,
            lambda done: request.progress("truths", done, len(truths)),
        )
        found = {part["truth"]: part for part in parts.values()}
        by_pair = {pair: [found[truth] for truth in members] for pair, members in settings.pairs.items()}
        used = versions_of(parts.values())
        record = {"settings": asdict(settings), "pairs": by_pair, "versions": used}
        return CampaignResult(
            files={PAGE: pairs_page(by_pair, settings, used), FIGURES: json_text(record)},
            record=record,
            summary=pairs_summary(by_pair),
        )
