"""The study of linearisation and feedforward: tuning, plants, figures and the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from distributed import Client

from flexros.scheduler import connected
from flexros.validation.campaigns.base import CampaignRequest
from flexros.validation.campaigns.linearisation import Linearisation
from flexros.validation.campaigns.linearisation.conditions import EXACT, Condition, draw_values
from flexros.validation.campaigns.linearisation.figures import duel, figure_of
from flexros.validation.campaigns.linearisation.law_part import law_part
from flexros.validation.campaigns.linearisation.laws import LAWS, Axis, axes_of, state_gains
from flexros.validation.campaigns.linearisation.robots import E12, ELBOW, Encoders, robot_with
from flexros.validation.campaigns.linearisation.sag import sag_of_static_linearisation
from flexros.validation.campaigns.linearisation.settings import LinearisationSettings
from flexros.validation.campaigns.linearisation.tuning import LinearLoops


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connected(threads=1) as made:
        yield made


def test_gains_of_a_nearly_rigid_axis_are_those_of_a_pd_controller() -> None:
    gains = state_gains(Axis(motor=2.0, link=3.0, free=3.0, stiffness=1e7, damping=100.0, friction=0.0), 10.0, 2**0.5)
    assert gains[0] + gains[2] == pytest.approx(5.0 * 10.0**2, rel=1e-3)
    assert gains[1] + gains[3] == pytest.approx(5.0 * 10.0 * 2.0, rel=1e-2)


def test_margins_of_a_pd_loop_follow_the_gain_and_the_delay() -> None:
    robot = robot_with("elbow", Encoders())
    law = next(law for law in LAWS if law.name == "PD + DAE feedforward")
    loops = LinearLoops(law, robot, axes_of(robot), ELBOW.poses[:1], 5e-4)
    soft, hard = loops.tuning(20.0, 1.0), loops.tuning(60.0, 1.0)
    assert 1.0 < soft.sensitivity < hard.sensitivity < 2.0
    assert soft.delay_margin > hard.delay_margin > 0.0
    assert hard.torque_noise == pytest.approx(3.0 * soft.torque_noise, rel=0.1)
    assert not np.isfinite(loops.tuning(600.0, 1.0).sensitivity)


def test_plants_are_drawn_within_their_error_and_the_same_for_every_law() -> None:
    plain, measured = (robot_with("elbow", Encoders(links)) for links in (False, True))
    condition = Condition("model error", "10 %", error=0.1)
    drawn = draw_values(plain, condition, 50, 1)
    stiffness = drawn["body_1.ry.stiffness"] / 2e5
    assert 0.9 < stiffness.min() < 0.92 < 1.08 < stiffness.max() < 1.1
    assert drawn["body_2.mass"] / 45.0 == pytest.approx(drawn["body_2.inertia.yy"] / 3.0)
    again = draw_values(measured, condition, 50, 1)
    assert all(np.array_equal(again[name], values) for name, values in drawn.items())
    double = draw_values(plain, Condition("model error", "20 %", error=0.2), 50, 1)
    assert double["body_1.ry.stiffness"] - 2e5 == pytest.approx(2.0 * (drawn["body_1.ry.stiffness"] - 2e5))


def test_median_and_interval_come_from_order_statistics_and_lost_runs_count_as_infinite() -> None:
    figure = figure_of([float(value) for value in range(1, 25)])
    assert (figure.median, figure.low, figure.high) == (12.5, 7.0, 18.0)
    half = figure_of([1.0, None, None])
    assert half.lost == 2
    assert not np.isfinite(half.median)


def test_a_duel_counts_runs_and_a_lost_run_loses() -> None:
    found = duel([1.0, 2.0, None], [2.0, 1.0, 1.0])
    assert (found.better, found.runs, found.ratio) == (1, 3, 2.0)


@pytest.mark.slow
def test_the_campaign_compares_laws(client: Client, tmp_path: Path) -> None:
    settings = LinearisationSettings(
        robots=(ELBOW,),
        laws=("static linearisation", "feedforward + states"),
        conditions=(EXACT,),
        tunings=("equal bandwidth",),
        repetitions=1,
    )
    result = Linearisation(settings).run(CampaignRequest(tmp_path, client))
    found = result.record["results"]["elbow"]["equal bandwidth"]
    runs = {law: found[law]["conditions"][EXACT.name] for law in settings.laws}
    assert runs["feedforward + states"]["track"][0] < 0.01 < runs["static linearisation"]["track"][0]
    sag = sag_of_static_linearisation(robot_with("elbow", Encoders(links=True)), ELBOW.poses[0], ELBOW.force, 50.0)
    assert runs["static linearisation"]["hold"][0] == pytest.approx(sag, rel=0.02)
    assert "| exact model: none |" in result.files["linearisation_study.md"]


def test_a_law_that_the_robot_does_not_fit_is_refused_with_the_reason() -> None:
    part = law_part(LinearisationSettings(), E12, "static linearisation", "equal bandwidth")
    assert "motor behind a spring" in part["refused"]
