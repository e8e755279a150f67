from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from flexros.identify.friction.laws import LAWS, fit_law
from flexros.identify.friction.measurement import FrictionMeasurement
from flexros.identify.friction.report import friction_figure, friction_report, with_deviation
from tests.identify.friction.test_laws import TRUE, points


@pytest.fixture(scope="module")
def measured() -> FrictionMeasurement:
    given = points("LuGre, steady", 0.02)
    return FrictionMeasurement("motor_1", given, tuple(fit_law(law, given) for law in LAWS))


def test_best_law_and_record(measured: FrictionMeasurement) -> None:
    record = measured.record()
    assert record["best"] == "LuGre, steady"
    assert [law["equation"] for law in record["laws"]] == ["3.14", "3.15", "3.16"]
    assert len(record["points"]) == 30


def test_a_law_that_the_speeds_do_not_determine_is_not_named_best(measured: FrictionMeasurement) -> None:
    """Three speeds in both directions pass through any law of four parameters."""
    loose = [replace(fit, deviations=np.full_like(fit.deviations, np.inf)) for fit in measured.fits[1:]]
    assert min(loose, key=lambda fit: fit.criterion).criterion < measured.fits[0].criterion
    few = FrictionMeasurement("motor_1", measured.points, (measured.fits[0], *loose))
    assert few.best is measured.fits[0]
    assert FrictionMeasurement("motor_1", measured.points, tuple(loose)).best is loose[0]


def test_picture_shows_the_points_and_every_law_as_it_was_fitted(measured: FrictionMeasurement) -> None:
    figure = friction_figure(measured)
    marks, *lines = [trace for trace in figure.data if trace.showlegend]
    np.testing.assert_allclose(marks.x, measured.points.speed)
    np.testing.assert_allclose(marks.y, measured.points.torque)
    assert [line.name for line in lines] == [
        "viscous and Coulomb (3.14)",
        "LuGre, steady (3.15)",
        "Feeny and Moon (3.16)",
    ]
    lugre = lines[1]
    true = LAWS[1].evaluate(np.asarray(lugre.x, dtype=float), np.array(TRUE["LuGre, steady"]))
    np.testing.assert_allclose(lugre.y, true, atol=0.15)
    assert min(abs(np.asarray(lugre.x))) < 1e-3, "the laws are drawn down to standstill"


def test_residuals_of_the_right_law_are_small(measured: FrictionMeasurement) -> None:
    rms = {
        trace.name: float(np.sqrt(np.mean(np.square(trace.y))))
        for trace in friction_figure(measured).data
        if trace.mode == "markers" and not trace.showlegend
    }
    assert rms["LuGre, steady (3.15)"] < 0.03 < 10 * 0.03 < rms["viscous and Coulomb (3.14)"]


def test_page_names_law_parameters_and_logs(measured: FrictionMeasurement) -> None:
    page = friction_report(measured, ["runs/slow", "runs/fast"])
    text = re.sub(r"<[^>]*>", "", page.split("<script", 1)[0])
    assert "LuGre, steady" in text
    assert "Nm s/rad" in text
    assert "runs/slow, runs/fast" in text


def test_force_of_a_prismatic_motor_is_in_newton(measured: FrictionMeasurement) -> None:
    linear = FrictionMeasurement("motor_1", measured.points, measured.fits, linear=True)
    assert linear.unit("f_v") == "N s/m"
    assert friction_figure(linear).layout.yaxis.title.text == "force [N]"


def test_too_few_points_for_any_law_are_shown(measured: FrictionMeasurement) -> None:
    few = FrictionMeasurement("motor_1", measured.points, ())
    assert few.best is None
    assert "too few speeds" in friction_report(few, ["log"])


@pytest.mark.parametrize(
    ("value", "deviation", "text"), [(5.9134, 0.0687, "5.913 ± 0.069"), (5.6e-9, 0.058, "0.000 ± 0.058")]
)
def test_digits_follow_the_deviation(value: float, deviation: float, text: str) -> None:
    assert with_deviation(value, deviation) == text
