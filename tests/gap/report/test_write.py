"""The page as a whole: one verdict after the other, every figure from the result."""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from plotly.offline import get_plotlyjs

from flexros.gap.report import diagnosis_report
from flexros.gap.result import DiagnosisResult
from flexros.gap.schema import Diagnosis, EffectLocation, ModelNumber, Partial
from flexros.robot import Robot

pytestmark = pytest.mark.slow

Diagnosed = Callable[[str], DiagnosisResult]
PATCH = "robot: four_mass_linear\neffects:\n  - effect: coulomb_friction <at> motor_1\n"
COULOMB = EffectLocation(effect="coulomb_friction", location="motor_1")
HYSTERESIS = EffectLocation(effect="hysteresis", location="motor_1")
ALWAYS = ("Where it shows", "Which effect", "How far apart, before and after", "Limits of this log")
VERDICTS = {
    "no_gap": (ALWAYS, ("The evidence", "The patch")),
    "explained": ((*ALWAYS, "The evidence", "The patch"), ()),
    "ambiguous": ((*ALWAYS, "The evidence", "The patch"), ()),
    "unknown_effect": ((*ALWAYS, "The evidence", "The patch"), ()),
}


def page(result: DiagnosisResult, patch: str = "") -> str:
    """The page without the plotting library."""
    return re.sub(r"<script>.*?</script>", "", diagnosis_report(result, patch=patch), flags=re.DOTALL)


def pictures(html: str) -> list[dict[str, object]]:
    return json.loads(re.search(r'id="pictures">(.*?)</script>', html, re.DOTALL)[1])  # type: ignore[index, no-any-return]


@pytest.mark.parametrize("verdict", VERDICTS)
def test_sections_follow_the_verdict(diagnosed: Diagnosed, verdict: str) -> None:
    there, absent = VERDICTS[verdict]
    html = page(diagnosed(verdict), "" if verdict == "no_gap" else PATCH)
    headings = re.findall(r"<h2 .*?>(.*?)</h2>", html)
    assert all(any(heading.startswith(title) for heading in headings) for title in there)
    assert not set(absent) & set(headings)


def test_page_needs_nothing_from_outside(diagnosed: Diagnosed) -> None:
    html = page(diagnosed("explained"))
    assert not re.search(r'(src|href)="(?!data:|#)', html)


def test_page_is_small_and_holds_the_whole_plotting_library(diagnosed: Diagnosed) -> None:
    html = diagnosis_report(diagnosed("explained"), patch=PATCH)
    packed = re.search(r'id="library">(.*?)</script>', html)
    assert packed is not None
    assert gzip.decompress(base64.b64decode(packed[1])).decode() == get_plotlyjs()
    assert len(html) < 3_000_000


def test_the_patch_can_be_copied_as_it_is(diagnosed: Diagnosed) -> None:
    html = page(diagnosed("explained"), PATCH)
    assert "<pre>robot: four_mass_linear\neffects:\n  - effect: coulomb_friction &lt;at&gt; motor_1\n</pre>" in html
    assert html.count(">copy</button>") == 2


def test_the_map_holds_every_place_that_was_looked_at(diagnosed: Diagnosed) -> None:
    bands, regimes, *_ = (entry["figure"]["data"] for entry in pictures(page(diagnosed("explained"))))  # type: ignore[index]
    by_regime = regimes[0]
    assert [(band["x"], band["z"]) for band in bands if band["y"] == [-0.5, 0.5]][:2] == [
        ([1.2, 2.0], [[61.0]]), ([2.0, 8.0], [[25.0]]),
    ]  # fmt: skip
    assert by_regime["x"] == ["reversal", "low speed", "standstill", "high torque", "high speed"]
    assert by_regime["customdata"][0][0] == 0.0004


def test_bars_of_probability_hold_nothing_too(diagnosed: Diagnosed) -> None:
    bars = pictures(page(diagnosed("no_gap")))[2]["figure"]["data"][0]  # type: ignore[index]
    assert bars["y"][-1] == "Nothing"
    assert bars["x"][-1] == pytest.approx(99.4)


def test_probabilities_of_an_unknown_cause_are_stated_as_those_of_the_known(diagnosed: Diagnosed) -> None:
    told = "Here none of them explains the gap, so none is probable"
    assert told in page(diagnosed("unknown_effect"))
    assert told not in page(diagnosed("explained"))


def test_rivals_of_a_group_have_a_colour_of_their_own(diagnosed: Diagnosed) -> None:
    bars = pictures(page(diagnosed("ambiguous")))[2]["figure"]["data"][0]  # type: ignore[index]
    colours = bars["marker"]["color"]
    assert colours[0] == colours[1] != colours[2]


def test_every_cause_has_its_bar(diagnosed: Diagnosed) -> None:
    first = diagnosed("explained").ranking[0]
    causes = tuple(replace(first, location=f"motor_{k}") for k in range(1, 13))
    ranking = (*causes, replace(first, probability=0.01, location="motor_13"))
    html = page(replace(diagnosed("explained"), ranking=ranking))
    assert html.count("1 less probable one is left out.") == 1


def test_gap_numbers_are_drawn_with_rival_and_floor(diagnosed: Diagnosed) -> None:
    bars = pictures(page(diagnosed("explained")))[3]["figure"]["data"][0]  # type: ignore[index]
    assert bars["x"] == [38.2, 2.9, 1.12, 1.0]
    assert bars["y"][0] == "nominal model: 38.2"


def test_without_a_repair_the_curves_show_the_nominal_model_alone(diagnosed: Diagnosed) -> None:
    told = pictures(page(diagnosed("no_gap")))[-1]["figure"]["data"]  # type: ignore[index]
    assert {trace["name"] for trace in told} == {"nominal model"}


def test_next_experiment_has_its_command(diagnosed: Diagnosed) -> None:
    html = page(diagnosed("ambiguous"))
    assert "<pre>flexros run bias_steps --model four_mass_linear --out bags/bias_steps</pre>" in html
    assert "41 nats" in html


def test_what_moved_within_tolerance_is_listed(diagnosed: Diagnosed) -> None:
    html = page(diagnosed("explained"))
    assert "+1.7" in html
    assert "body_2.rz.stiffness" not in html


def test_a_result_with_little_is_rendered_all_the_same(changed: Callable[..., DiagnosisResult]) -> None:
    bare = changed("no_gap", ranking=(), excess=(), signals=(), holdout=None, tolerance={}, limits=(), timings={})
    html = page(replace(bare, before=replace(bare.before, holdout=None)))
    assert "No effects were compared" in html
    assert "Where it shows</h2>" not in html


def test_a_prediction_that_diverged_is_drawn_all_the_same(changed: Callable[..., DiagnosisResult]) -> None:
    known = changed("explained")
    assert known.after is not None
    assert known.after.holdout is not None
    gone = known.after.holdout.innovations.copy()
    gone[4000:] = np.nan
    gone[3990:4000] = 1e300
    broken = replace(known.after, holdout=replace(known.after.holdout, innovations=gone))
    told = pictures(page(replace(known, after=broken)))[-1]["figure"]["data"]  # type: ignore[index]
    assert [trace["name"] for trace in told[:2]] == ["nominal model", "nominal model"]


def test_the_title_may_be_another_one(diagnosed: Diagnosed) -> None:
    assert "<title>My robot</title>" in diagnosis_report(diagnosed("explained"), title="My robot")


def test_joints_of_the_imported_model_are_named(changed: Callable[..., DiagnosisResult]) -> None:
    robot = changed("explained").robot
    spec = robot.spec.model_copy(update={"tags": {"motor_1.joint": "panda_joint4", "motor_1.joint_sign": "-1"}})
    html = page(changed("explained", robot=Robot(spec, "arm.yaml")))
    assert "Joints: motor_1 = panda_joint4; panda_joint4 counts the other way round." in html


def test_a_partial_result_says_so_at_the_top(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    partial = Partial(reason="interrupted", after=61.3, step="single effects")
    html = page(replace(result, diagnosis=result.diagnosis.model_copy(update={"partial": partial})))
    assert "interrupted after 61.3 s" in html.partition("<h2 ")[0]
    assert "Partial result" not in page(result)


def test_the_budget_is_drawn_and_its_negative_shares_are_explained(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    html = page(replace(diagnosed("explained"), diagnosis=divided), PATCH)
    assert "The budget of the gap" in html
    assert "<td>worse alone</td>" in html
    assert "Worse alone: the effect has the size" in html
    assert "A share below zero" not in html
    assert any(trace["type"] == "waterfall" for one in pictures(html) for trace in one["figure"]["data"])  # type: ignore[index]
    assert "Closed by the largest part" in html


def test_a_share_above_the_whole_gap_is_no_figure(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    budget = tuple(share.model_copy(update={"share_last": 3.98}) for share in divided.budget)
    html = page(replace(diagnosed("explained"), diagnosis=divided.model_copy(update={"budget": budget})), PATCH)
    assert "<td>worse without it</td>" in html
    assert "Worse without it: the other effects" in html
    assert "398 %" not in html
    assert "398\u00a0%" not in html


def test_a_share_that_may_be_above_zero_is_stated(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    budget = tuple(share.model_copy(update={"interval": (-0.7, 0.1)}) for share in divided.budget)
    html = page(replace(diagnosed("explained"), diagnosis=divided.model_copy(update={"budget": budget})), PATCH)
    assert "\u221230\u00a0%" in html
    assert "A share below zero" in html
    assert "worse alone" not in html


def test_the_first_tile_counts_what_the_model_lacks(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    hysteresis, coulomb = divided.budget
    rotor = coulomb.model_copy(update={"effect": "rotor_inertia", "share_first": 0.7, "share_last": 0.8})
    known = divided.model_copy(update={"budget": (rotor, hysteresis, coulomb)})
    tile = page(replace(diagnosed("explained"), diagnosis=known)).partition("Closed by the largest part, at least")[2]
    assert "70" in tile[:100]
    assert "By rotor inertia at motor_1, added first or removed last; 2 more in the patch" in tile


def test_the_joint_of_the_gap_is_not_mixed_up_with_the_map(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    second = divided.waterfall[0].model_copy(update={"joint": "motor_2", "before": 0.2})
    first = divided.waterfall[0].model_copy(update={"before": 0.8})
    known = divided.model_copy(update={"waterfall": (second, first)})
    tiles = page(replace(diagnosed("explained"), diagnosis=known))
    assert 'motor_1<small></small></div><div class="below">80\u00a0% of the held-out gap' in tiles.replace("\n", "")
    assert "Clearest sign, before any hypothesis" in tiles


def test_the_verdict_comes_first_with_its_word(diagnosed: Diagnosed) -> None:
    assert '<p class="lead">Unknown effect: There is a gap' in page(diagnosed("unknown_effect"))
    assert '<p class="lead">No gap: model and log agree' in page(diagnosed("no_gap"))


def test_a_rival_has_its_bar_however_many_causes_come_before(diagnosed: Diagnosed) -> None:
    result = diagnosed("ambiguous")
    causes = tuple(replace(result.ranking[0], location=f"motor_{k}", probability=1.0) for k in range(2, 13))
    bars = pictures(page(replace(result, ranking=(*causes, *result.ranking))))[2]["figure"]["data"][0]  # type: ignore[index]
    assert "Backlash at motor_1" in bars["y"]
    assert "Coulomb friction at motor_1" not in bars["y"]


def test_figures_of_a_whole_explanation_are_written_once(diagnosed: Diagnosed) -> None:
    first, second, *_ = diagnosed("explained").ranking
    pair = (replace(first, together_with=(HYSTERESIS,)), replace(second, gain=first.gain, together_with=(COULOMB,)))
    html = page(replace(diagnosed("explained"), ranking=pair))
    table = html.partition("Gain: twice the gain")[2].partition("</table>")[0]
    assert table.count("<td>5400</td>") == 1
    assert table.count("(with hysteresis at motor_1)") == 1
    assert "(with Coulomb friction at motor_1)" not in table
    assert html.count("twice the log-likelihood by 5400") == 1


def test_numbers_of_a_table_stay_beside_their_per_cent_sign(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    html = page(replace(diagnosed("explained"), diagnosis=divided))
    assert " %" not in "".join(re.findall(r"<td.*?</td>", html))


def test_a_load_that_the_model_lacks_has_its_size_in_the_budget(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    load = divided.budget[0].model_copy(update={"joint": "tool", "location": "tool", "effect": "tool_load"})
    sizes = {"location": "tool", "nominal": 0.0, "std": 0.1}
    numbers = tuple(
        ModelNumber(name=f"tool_load.{name}", value=value, unit=unit, **sizes)
        for name, value, unit in (("mass", 1.2, "kg"), ("x", 0.4, "m"))
    )
    known = divided.model_copy(update={"budget": (load, *divided.budget), "model_numbers": numbers})
    html = page(replace(diagnosed("explained"), diagnosis=known))
    assert 'Tool load</td><td class="left">mass 1.20 kg (±0.10), x 0.40 m (±0.10)</td>' in html


def test_numbers_of_the_model_that_are_not_determined_are_said_so(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    known = {"location": "motor_1", "nominal": 0.0, "value": 1.2, "std": 0.1, "unit": "kg m2"}
    numbers = (
        ModelNumber(name="motor_1.inertia", **known),
        ModelNumber(name="motor_2.inertia", **{**known, "std": 2.0}, determined=False),
    )
    html = page(replace(diagnosed("explained"), diagnosis=divided.model_copy(update={"model_numbers": numbers})))
    assert "motor_1.inertia</td><td>0</td><td>1.20 (±0.10)</td>" in html
    assert "motor_2.inertia</td><td>0</td><td>not determined</td>" in html


def test_a_cause_without_a_size_is_said_beside_its_probability(diagnosed: Diagnosed) -> None:
    result = diagnosed("explained")
    cause = result.diagnosis.causes[0].model_copy(update={"determined": False})
    html = page(replace(result, diagnosis=result.diagnosis.model_copy(update={"causes": (cause,)})))
    assert "Coulomb friction at motor_1: present, size not determined: level between" in html


def test_probabilities_with_other_tolerances_are_a_table(diagnosed: Diagnosed, guessed: Diagnosis) -> None:
    html = page(replace(diagnosed("ambiguous"), diagnosis=guessed), PATCH)
    assert re.search(r"Backlash at motor_1</td><td>0.%</td><td>3.%</td><td>98.%</td>", html)
    assert "A name that changes is ambiguous" in html


def test_causes_of_a_part_of_the_gap_have_their_colour(diagnosed: Diagnosed, divided: Diagnosis) -> None:
    html = page(replace(diagnosed("explained"), diagnosis=divided), PATCH)
    bars = [trace for one in pictures(html) for trace in one["figure"]["data"] if trace["type"] == "bar"]  # type: ignore[index]
    (ranking,) = (bar for bar in bars if bar["y"][0] == "Coulomb friction at motor_1")
    assert ranking["marker"]["color"][0] == "#0072b2"
