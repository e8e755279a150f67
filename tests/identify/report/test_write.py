"""The page: every section, offline, small; sections that do not apply are left out."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from flexros.identify.report.multistart import StartSection
from flexros.identify.report.responses import POINTS
from flexros.identify.report.write import SECTIONS, identification_report
from flexros.identify.result import IdentificationResult

pytestmark = pytest.mark.slow


def words(html: str) -> str:
    """Return what is read, without scripts and tags."""
    text = unescape(re.sub(r"<[^>]+>", " ", re.sub(r"<(script|style).*?</\1>", "", html, flags=re.DOTALL)))
    return text.replace("\u00a0", " ")


def pictures(html: str) -> list[dict[str, object]]:
    data = re.search(r'id="pictures">(.*?)</script>', html, re.DOTALL)
    assert data
    return [entry["figure"] for entry in json.loads(data[1])]


@pytest.fixture(scope="module")
def html(clear: IdentificationResult) -> str:
    return identification_report(clear)


def test_page_opens_offline_and_is_small(html: str) -> None:
    assert get_plotlyjs() in html
    outside = html.replace(get_plotlyjs(), "")
    assert not re.search(r"(src|href)=[\"']?https?:", outside)
    assert len(html) < 15e6


def test_every_section_appears_once(html: str) -> None:
    for section in SECTIONS:
        if section.title:
            assert html.count(f">{section.title}</h2>") == 1


def test_page_begins_with_the_verdict_and_the_main_figures(html: str) -> None:
    text = words(html).partition("Contents")[2].partition("FlexROS")[2]
    assert text.index("6 of 6 parameters of e12 are determined within 10 %") < text.index("Parameters")
    assert "6.67 min" in " ".join(text.split())
    assert "amplitudes were lowered" in text


def test_table_shows_nominal_identified_true_and_verdict(html: str) -> None:
    row = re.search(r"body_1\.ry\.stiffness</td>(.*?)</tr>", html, re.DOTALL)
    assert row
    cells = words(row[1]).split()
    assert cells[0] == "Nm/rad"
    assert cells[1] == "100000"
    assert float(cells[2]) == pytest.approx(1.2e5, rel=0.02)
    assert cells[-2:] == ["determined", "120000"]


def test_responses_have_a_panel_per_pair_and_menus_for_position_and_view(html: str) -> None:
    figure = pictures(html)[1]
    menus = figure["layout"]["updatemenus"]  # type: ignore[index]
    assert [button["label"] for button in menus[0]["buttons"]] == ["magnitude", "phase [°]"]
    assert len(menus[1]["buttons"]) == 3
    assert len(figure["data"]) == 4 * 7  # type: ignore[arg-type]
    for button in menus[1]["buttons"]:
        assert len(button["args"][0]["y"]) == 4 * 7
    shown = menus[0]["buttons"][1]["args"][0]["visible"]
    assert shown == [False, False, False, False, True, True, True] * 4


def test_first_position_is_drawn_with_its_own_numbers(html: str, clear: IdentificationResult) -> None:
    figure = pictures(html)[1]
    measured = figure["data"][1]["y"]  # type: ignore[index]
    assert measured == pytest.approx(abs(clear.problem.responses[0].response[:, 0, 0]), rel=1e-3)
    band = figure["data"][0]["y"]  # type: ignore[index]
    assert all(top >= value for top, value in zip(band, measured, strict=False))


def test_costs_are_drawn_only_where_they_differ(clear: IdentificationResult) -> None:
    worse = replace(clear.fit, cost=3 * clear.fit.cost)
    (sentence,) = StartSection().blocks(replace(clear, searched=(clear.fit,) * 3))
    assert "3 of 3 fits" in sentence.text  # type: ignore[union-attr]
    sentence, picture = StartSection().blocks(replace(clear, searched=(clear.fit, worse)))
    assert "the others cost up to 3 times as much" in sentence.text  # type: ignore[union-attr]
    assert list(picture.figure.data[0].y) == pytest.approx([1, 3])  # type: ignore[union-attr]


def test_models_are_drawn_between_the_lines_too(html: str, clear: IdentificationResult) -> None:
    figure = pictures(html)[1]
    identified = figure["data"][3]  # type: ignore[index]
    lines = clear.problem.frequency
    assert identified["name"] == "identified model"
    assert len(identified["x"]) == len(identified["y"]) == POINTS
    assert identified["x"][:: POINTS - 1] == pytest.approx([lines[0], lines[-1]], rel=1e-3)
    at_lines = abs(clear.residuals.response[0, :, 0, 0])
    assert identified["y"][:: POINTS - 1] == pytest.approx(at_lines[[0, -1]], rel=1e-3)
    assert max(identified["y"]) > 1.1 * at_lines.max()
    for button in figure["layout"]["updatemenus"][1]["buttons"]:  # type: ignore[index]
        assert [len(values) for values in button["args"][0]["y"][2:4]] == [POINTS, POINTS]
        assert "x" not in button["args"][0]


def test_distortions_are_named_with_their_size(distorted: IdentificationResult) -> None:
    text = words(identification_report(distorted))
    assert "odd ones at motor_2, 5 % of the output in the median, with noise of 0.10 %" in text
    assert "as far as noise goes. With the weights of the fit the identified model explains" in text
    assert "Signs of it: odd detection lines of motor_2 carry 50 times their noise." in text
    assert "errors may exceed them" in text


def test_gain_of_the_positions_is_told(html: str, clear: IdentificationResult) -> None:
    assert clear.design is not None
    assert f"chosen out of {clear.design.origin}, such that" in " ".join(words(html).split())


def test_provenance_and_all_warnings_stand_at_the_end(html: str) -> None:
    end = words(html[html.rindex("Provenance and limits") :])
    assert "seed" in end
    assert "a gap of 2 samples (alike in 2 more positions)" in end


def test_what_is_not_determined_is_listed_with_an_experiment(noisy: IdentificationResult) -> None:
    text = words(identification_report(noisy))
    assert noisy.design is not None
    count = len(noisy.design.candidates.gears)
    assert f"The single further experiment that helps most, out of {count} candidate positions" in text
    assert noisy.identifiability.names("not_determined")[0] in text


def test_sections_without_content_are_left_out(make: Callable[..., IdentificationResult]) -> None:
    text = words(identification_report(make(10.0, levels=False, known=False)))
    assert "Noise and nonlinear distortions" not in text
    assert "The responses have no covariance" in text


def test_bias_by_model_form_errors_is_warned_of_and_only_then(html: str, clear: IdentificationResult) -> None:
    for warning in ("errors may exceed them", "form error", "as far as", "What exceeds it"):
        assert warning not in words(html)
    missing = replace(clear, covariance=replace(clear.covariance, reduced_cost=12.0))
    text = words(identification_report(missing))
    assert "errors may exceed them" in text
    assert "within 10 % as far as noise goes. The identified model misses the responses in 3 positions by 3.5" in text
    assert "slow_motion" in text
    assert "What exceeds it is not noise" in text


def test_report_of_responses_from_plain_arrays_names_positions_by_number(noisy: IdentificationResult) -> None:
    bare = tuple(replace(each, gears=np.full(2, np.nan)) for each in noisy.problem.responses)
    text = words(identification_report(replace(noisy, problem=replace(noisy.problem, responses=bare), design=None)))
    assert re.search(r"measured position [123]", text)
    assert "out of 3 measured positions" in text


def test_starts_that_failed_are_counted(clear: IdentificationResult) -> None:
    failed = replace(clear.searched[0], cost=math.nan, converged=False)
    text = words(identification_report(replace(clear, searched=(failed, *clear.searched))))
    assert f"{clear.same_minimum} of 5 fits (LLS, user weights) ended in the best minimum" in text
    assert "1 failed, because the model cannot be evaluated at their starts" in text
