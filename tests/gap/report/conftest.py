"""Results of diagnoses made by hand, one per verdict, for reports."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.kinds.base import PlacedEffect
from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.result import DiagnosisResult, Explanation, RankedCandidate, SignalGap
from flexros.gap.schema import (
    BandShare,
    BudgetShare,
    Cause,
    CauseParameter,
    Diagnosis,
    EffectLocation,
    Excess,
    Step,
    ToleranceSensitivity,
    Unexplained,
    Waterfall,
)
from flexros.gap.settings import DiagnosisSettings
from flexros.record.record import Record
from flexros.robot import load_robot

ROBOT = load_robot("four_mass_linear")
N, T, SIGMA = 8000, 5e-4, 1e-4
COULOMB = EffectLocation(effect="coulomb_friction", location="motor_1")
HYSTERESIS = EffectLocation(effect="hysteresis", location="motor_1")
BACKLASH = EffectLocation(effect="backlash", location="motor_1")
BANDS = ((0.0, 2.0), (2.0, 8.0), (8.0, 20.0), (20.0, 60.0), (60.0, 200.0), (200.0, 1e9))
REGIMES = ("reversal", "low speed", "standstill", "high torque", "high speed")
NUMBERS = {
    "coulomb_friction": {"level": (0.213, 0.011, "Nm"), "asymmetry": (0.05, 0.12, "1")},
    "hysteresis": {"level": (0.2, 0.02, "Nm"), "transition": (1.2e-4, 3e-5, "rad")},
    "backlash": {"gap": (2.1e-4, 3e-6, "rad")},
    "stiffness_error": {"relative": (-0.052, 0.003, "1")},
}


def record(name: str, seed: int) -> Record:
    """Motion to and fro, with a torque in step with it."""
    rng = np.random.default_rng(seed)
    time = T * np.arange(N)
    position = (np.sin(2 * np.pi * 0.5 * time) + SIGMA * rng.normal(size=N))[:, None]
    torque = (np.cos(2 * np.pi * 0.5 * time) + 0.1 * rng.normal(size=N))[:, None]
    return Record(name, T, position, torque, np.ones(N, bool), measured_torque=False, simulated=True)


def prediction(share: float, seed: int) -> PredictedLog:
    """White errors, and a share of them in step with the reversals."""
    rng = np.random.default_rng(seed)
    white = rng.normal(size=N)
    gap = share * np.sign(np.sin(2 * np.pi * 0.5 * T * np.arange(N)))
    states = np.zeros((N, 2 * ROBOT.n_dof)) if hasattr(ROBOT, "n_dof") else None
    return PredictedLog((SIGMA * (white + gap))[:, None], np.array([SIGMA]), states)


def explanation(name: str, share: float, seed: int) -> Explanation:
    return Explanation(name, prediction(share, seed), prediction(share, seed + 1))


def parameters(effect: str) -> dict[str, CauseParameter]:
    return {
        name: CauseParameter(value=value, std=std, unit=unit) for name, (value, std, unit) in NUMBERS[effect].items()
    }


def candidate(effect: str, location: str, probability: float, gain: float, remainder: float) -> RankedCandidate:
    fitted = parameters(effect)
    return RankedCandidate(effect, location, fitted, gain, 11.0 * len(fitted), probability, 0.4 * gain, remainder)


RANKING = {
    "no_gap": [("coulomb_friction", "motor_1", 0.004, 6.0, 0.99), ("backlash", "motor_1", 0.002, 3.0, 0.999)],
    "explained": [
        ("coulomb_friction", "motor_1", 0.97, 5400.0, 0.004),
        ("hysteresis", "motor_1", 0.03, 5200.0, 0.04),
        ("backlash", "motor_1", 1e-6, 1900.0, 0.6),
        ("stiffness_error", "body_1.rz", 1e-9, -4.0, 1.0),
    ],
    "ambiguous": [
        ("hysteresis", "motor_1", 0.56, 5400.0, 0.012),
        ("backlash", "motor_1", 0.43, 5399.0, 0.013),
        ("coulomb_friction", "motor_1", 0.01, 2000.0, 0.6),
    ],
    "unknown_effect": [
        ("coulomb_friction", "motor_1", 0.7, 3000.0, 0.42),
        ("hysteresis", "motor_1", 0.2, 2900.0, 0.45),
    ],
}
GAP = {"no_gap": (1.03, None), "explained": (38.2, 1.12), "ambiguous": (38.2, 1.6), "unknown_effect": (38.2, 16.6)}


def places(verdict: str) -> tuple[Excess, ...]:
    """A gap at low frequencies and at reversals; where there is none, nothing significant."""
    found = verdict != "no_gap"
    shares = [0.61, 0.25, 0.1, 0.04, 0.0, 0.0]
    by_band = [
        Excess(
            signal="position", joint="motor_1", band_hz=band, regime="all", share=share if found else 1 / 6,
            p_value=0.0004 if found and share > 0.03 else 0.62,
        )
        for band, share in zip(BANDS, shares, strict=True)
    ]  # fmt: skip
    by_regime = [
        Excess(
            signal="position", joint="motor_1", band_hz=(0.0, 1e9), regime=regime, share=share if found else 0.2,
            p_value=0.0004 if found and share > 0.1 else 0.81,
        )
        for regime, share in zip(REGIMES, (0.7, 0.15, 0.02, 0.08, 0.05), strict=True)
    ]  # fmt: skip
    return (*by_band, *by_regime)


def diagnosis(verdict: str) -> Diagnosis:
    before, after = GAP[verdict]
    closed = None if after is None else (before - after) / (before - 1.0)
    ranked = [] if verdict == "no_gap" else RANKING[verdict]
    causes = [
        {
            "effect": effect, "location": location, "probability": probability,
            "parameters": parameters(effect), "closed_fraction": 1 - remainder,
        }
        for effect, location, probability, _, remainder in ranked
    ]  # fmt: skip
    following = {
        "name": "bias_steps", "description": "small reversals under a constant load, at three loads",
        "separates": (HYSTERESIS, BACKLASH), "expected_gain": 41.0,
        "command": "flexros run bias_steps --model four_mass_linear --out bags/bias_steps",
    }  # fmt: skip
    return Diagnosis(
        schema=2,
        verdict=verdict,
        causes=tuple(causes),
        ambiguity_groups=((HYSTERESIS, BACKLASH),) if verdict == "ambiguous" else (),
        where=tuple(place for place in places(verdict) if place.p_value < 0.05),
        gap={
            "metric": "mean squared prediction error 0.1 s ahead over its floor variance", "unit": "1",
            "before": before, "after": after, "noise_floor": 1.0, "closed_fraction": closed,
            "best_rival": None if after is None else 2.9, "interval": None if after is None else (closed - 0.01, 0.999),
        },
        next_experiment=following if verdict == "ambiguous" else None,
        warnings=("12 of 8000 samples are missing",) if verdict == "explained" else (),
        provenance={"log": {"name": "fit", "seed": 4}, "model": "four_mass_linear"},
    )  # fmt: skip


def result_of(verdict: str) -> DiagnosisResult:
    """Make a result with this verdict."""
    found = verdict != "no_gap"
    share = {"no_gap": 0.0, "unknown_effect": 3.0}.get(verdict, 0.1)
    level = PlacedEffect(CoulombFriction(level=0.213), "motor_1")
    return DiagnosisResult(
        diagnosis=diagnosis(verdict),
        robot=ROBOT,
        record=record("fit", 1),
        holdout=record("held out", 2),
        before=explanation("nominal", 5.0 if found else 0.0, 3),
        ranking=tuple(candidate(*entry) for entry in RANKING[verdict]),
        null_probability=0.0 if found else 0.994,
        after=explanation("coulomb_friction@motor_1", share, 5) if found else None,
        rival=explanation("hysteresis@motor_1", 1.0, 7) if found else None,
        patch=(level,) if found else (),
        covariance_of=("coulomb_friction@motor_1.level",) if found else (),
        covariance=np.array([[1.2e-4]]) if found else None,
        excess=places(verdict),
        signals=(SignalGap("motor_1 position, 0.1 s ahead", "mrad", 2.2, 0.39 if found else None, 0.37, 0.5),
                 SignalGap("tool path in closed loop", "mm", 1.9, 0.08 if found else None, None, None)),
        tolerance={"body_1.rz.stiffness": 1.7, "body_2.rz.stiffness": 0.1},
        limits=("A payload error cannot be told from an error of the last inertia by motor encoders alone.",),
        settings=DiagnosisSettings(level=5e-4),
        timings={"fit": 3.2, "where": 0.4},
    )  # fmt: skip


@pytest.fixture
def diagnosed() -> Callable[[str], DiagnosisResult]:
    """Return a function that makes a result with a verdict."""
    return result_of


@pytest.fixture
def changed() -> Callable[..., DiagnosisResult]:
    """Return a function that makes a result with a verdict and replaces fields of it."""
    return lambda verdict, **fields: replace(result_of(verdict), **fields)


def share(effect: str, first: float, last: float) -> BudgetShare:
    names = {"joint": "motor_1", "class": "friction", "effect": effect, "location": "motor_1"}
    return BudgetShare.model_validate({**names, "share_first": first, "share_last": last, "interval": None})


@pytest.fixture
def divided() -> Diagnosis:
    """Two effects at two joints close most of the gap, the less probable one more of it."""
    closed = {"hysteresis": 0.6, "coulomb_friction": 0.25}
    bands = (BandShare(band_hz=(0.0, 2.0), share=0.1), BandShare(band_hz=(2.0, 4.0), share=0.05))
    steps = tuple(Step(effect=effect, location="motor_1", share=part) for effect, part in closed.items())
    causes = tuple(
        Cause(effect=effect, location="motor_1", probability=p, parameters=parameters(effect), closed_fraction=None)
        for effect, p in (("hysteresis", 0.98), ("coulomb_friction", 0.99))
    )
    changed = {
        "verdict": "partly_explained",
        "causes": causes,
        "budget": (share("hysteresis", -0.3, 0.6), share("coulomb_friction", 0.25, 0.2)),
        "waterfall": (Waterfall(joint="motor_1", before=1.0, steps=steps, left=0.15),),
        "unexplained": (
            Unexplained(joint="motor_1", regime="all", share=0.15, bands=bands),
            Unexplained(joint="motor_1", regime="reversal", share=0.12),
        ),
    }
    return diagnosis("explained").model_copy(update=changed)


@pytest.fixture
def guessed() -> Diagnosis:
    """Backlash is named with doubled tolerances instead of hysteresis."""
    rows = (
        ToleranceSensitivity(**HYSTERESIS.model_dump(), halved=0.99, stated=0.97, doubled=0.02, changes=True),
        ToleranceSensitivity(**BACKLASH.model_dump(), halved=0.0, stated=0.03, doubled=0.98, changes=True),
        ToleranceSensitivity(**COULOMB.model_dump(), halved=1.0, stated=1.0, doubled=1.0, changes=False),
    )
    return diagnosis("ambiguous").model_copy(update={"tolerance_sensitivity": rows})
