"""Pictures of signatures, from numbers to the page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from flexros.gap.report import signature_pictures as module
from flexros.gap.report.evidence import EvidenceSection
from flexros.gap.report.signature_pictures import signature_pictures
from flexros.gap.result import DiagnosisResult
from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, signatures
from flexros.gap.signatures.signature_data import SignatureData
from flexros.prediction.observer import observer_gain

Changed = Callable[..., DiagnosisResult]


class Speed(AbstractSignature):
    """Torque against speed, with its title telling the place."""

    name: ClassVar[str] = "speed"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        assert evidence.robot.name == "four_mass_linear"
        curve = Curve(np.array([-1.0, 0.0, 1.0]), np.array([-0.2, np.nan, 0.2]))
        told = {
            "nominal": curve,
            "repaired": Curve(curve.x, 0 * curve.y, "points"),
            "level": Curve(curve.x, curve.y, "bars"),
        }
        return Picture(
            f"Torque against speed, {location}", "speed [rad/s]", "torque [Nm]", told, "Steps at zero.", log_y=True
        )


class Absent(Speed):
    """A picture that this log cannot show."""

    name: ClassVar[str] = "absent"

    def picture(self, evidence: SignatureData, location: str) -> Picture | None:
        return None


@pytest.fixture
def result(changed: Changed, monkeypatch: pytest.MonkeyPatch) -> DiagnosisResult:
    monkeypatch.setattr(module, "pictures_for", lambda effect: (Absent, Speed))
    known = changed("explained")
    observer = observer_gain(known.robot, 5e-4, 1e-3, known.robot.encoder_noise)
    return changed("explained", signature_data=SignatureData(known.robot, known.record, observer, known.before.fit))


def test_curves_are_drawn_as_they_ask(result: DiagnosisResult) -> None:
    (picture,) = signature_pictures(result.ranking[0], result)
    assert picture.caption == "Torque against speed, motor_1. Steps at zero."
    points, line, bars = picture.figure.data  # points lie below
    assert (line.mode, points.mode, bars.type) == ("lines", "markers", "bar")
    assert picture.figure.layout.yaxis.type == "log"
    assert picture.figure.layout.xaxis.title.text == "speed [rad/s]"


def test_effects_at_one_joint_share_a_picture(result: DiagnosisResult) -> None:
    captions = [block.caption for block in EvidenceSection().blocks(result) if hasattr(block, "figure")]
    assert captions == ["Torque against speed, motor_1. Steps at zero."]


def test_without_predictions_there_are_no_pictures(changed: Changed) -> None:
    known = changed("explained")
    assert signature_pictures(known.ranking[0], known) == ()


def test_outliers_of_a_cloud_do_not_flatten_the_curves() -> None:
    cloud = np.r_[np.linspace(-1.0, 1.0, 400), -50.0]
    told = {
        "samples": Curve(np.arange(401.0), cloud, "points"),
        "before": Curve(np.array([0.0, 400.0]), np.array([-2.0, 1.5])),
    }
    figure = module._figure(Picture("", "", "", told, ""))
    assert figure.layout.yaxis.range == pytest.approx((-2.0, 1.5), rel=0.2)


@pytest.mark.parametrize("samples", [0, 1, 2, 9, 60])
@pytest.mark.parametrize("name", signatures())
def test_logs_of_few_samples_are_drawn(
    name: str, samples: int, result: DiagnosisResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No part of the abscissa has enough samples for a mean then; single samples are shown, or nothing."""
    monkeypatch.setattr(module, "pictures_for", lambda effect: (signatures()[name],))
    data = result.signature_data
    assert data is not None
    valid = np.zeros(data.record.n_samples, dtype=bool)
    valid[4000 : 4000 + samples] = True
    states = 0.01 * np.random.default_rng(0).normal(size=(len(valid), 2 * data.robot.n_coordinates))
    short = replace(
        data,
        record=replace(data.record, valid=valid),
        before=replace(data.before, states=states),
        after=data.before,
        repaired=data.robot,
    )
    for picture in signature_pictures(result.ranking[0], replace(result, signature_data=short)):
        assert all(np.isfinite(trace.y).any() for trace in picture.figure.data)
