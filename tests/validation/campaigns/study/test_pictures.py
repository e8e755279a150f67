from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import TYPE_CHECKING

from flexros.validation.campaigns.study.page import CAPTIONS
from flexros.validation.campaigns.study.pictures import pictures

if TYPE_CHECKING:
    from flexros.validation.campaigns.study.jobs import Study


def test_every_picture_of_the_paper_is_drawn(small_study: Study) -> None:
    drawn = pictures(small_study)
    assert list(drawn) == list(CAPTIONS)
    assert [len(drawing.panels) for drawing in drawn.values()] == [1, 1, 6, 6, 6, 4]
    for drawing in drawn.values():
        ET.fromstring(drawing.svg())


def test_costs_have_a_line_per_estimator_and_the_limit(small_study: Study) -> None:
    panel = pictures(small_study)["costs_user_weights"].panels[0]
    assert len(panel.items) == 6
    assert panel.levels == (1.5,)
