"""The result of a diagnosis, with all that its report shows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from flexros.gap.settings import DiagnosisSettings

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.base import PlacedEffect
    from flexros.gap.prediction.predicted_log import PredictedLog
    from flexros.gap.schema import CauseParameter, Diagnosis, EffectLocation, Excess
    from flexros.gap.signatures.signature_data import SignatureData
    from flexros.record.record import Record
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class Explanation:
    """A model of the robot with its predictions of both logs.

    Attributes:
        name: Its effects, e.g. "coulomb_friction@motor_1", or "nothing".
        fit: Prediction of the fitted log.
        holdout: Prediction of the held-out log; None where there is none.
        effects: The effects on the nominal robot, with their fitted parameters.
    """

    name: str
    fit: PredictedLog
    holdout: PredictedLog | None = None
    effects: tuple[PlacedEffect, ...] = ()


@dataclass(frozen=True, eq=False)
class RankedCandidate:
    """An effect at a location in the ranking.

    Attributes:
        effect: Name of the effect.
        location: Its location.
        parameters: Fitted parameters by name.
        gain: Twice the gain in log-likelihood over the nominal model on the fit log [1].
        penalty: Penalty of its parameters, in the unit of `gain` [1].
        probability: That this effect is part of the truth [1].
        holdout_gain: The gain on the held-out log [1]; None where not computed.
        remainder: Share of the excess over the noise floor that it leaves in the fit log [1]; None where not computed.
        together_with: The other effects of the explanation that these figures are of.
    """

    effect: str
    location: str
    parameters: Mapping[str, CauseParameter]
    gain: float
    penalty: float
    probability: float
    holdout_gain: float | None = None
    remainder: float | None = None
    together_with: tuple[EffectLocation, ...] = ()

    @property
    def score(self) -> float:
        """Gain less penalty [1]; above zero where the effect is worth its parameters."""
        return self.gain - self.penalty


@dataclass(frozen=True)
class SignalGap:
    """The gap in one signal, in its own unit.

    Attributes:
        signal: E.g. "motor_1 position, 0.1 s ahead", or "tool path in closed loop".
        unit: E.g. "mrad", "mm".
        before: With the nominal model, rms.
        after: With the repaired model; None where nothing was repaired.
        floor: Without any gap; None where not known.
        rival: With the best explanation that was not chosen; None where there is none.
    """

    signal: str
    unit: str
    before: float
    after: float | None = None
    floor: float | None = None
    rival: float | None = None


@dataclass(frozen=True, eq=False)
class DiagnosisResult:
    """The result of a diagnosis.

    Attributes:
        diagnosis: The answer, as written into diagnosis.json.
        robot: The nominal robot.
        record: The fitted log.
        holdout: The held-out log; None where none could be set aside.
        before: The nominal model, fitted within its tolerance.
        ranking: All effects that competed, what closes most of the held-out gap first, equal ones by probability.
        null_probability: Probability that no effect is there [1].
        after: The model with the causes; None where none was found.
        rival: The best explanation that was not chosen; None where there is none.
        patch: The effects that repair the model, with their fitted parameters; empty where none was found and
            the model lacks no number.
        covariance_of: Names of fitted parameters, e.g. "coulomb_friction@motor_1.level", in the order of `covariance`.
        covariance: Covariance of the fitted parameters [SI], shape (p, p); None where none was found.
        excess: Excess at all locations, significant or not: per joint and band over the regime "all",
            and per joint and regime over the whole band.
        signals: The gap by signal, on held-out data, and in closed loop where reference and controller are known.
        signature_data: Data of the signature pictures: the fitted log with the predictions of the nominal and the
            repaired model, states included; None leaves these pictures out.
        tolerance: Parameters that were moved within their tolerance, in standard deviations of it [1].
        limits: What the signals of this log cannot show, a sentence each.
        settings: Settings of the diagnosis.
        timings: Time that each stage took [s], by its name.
    """

    diagnosis: Diagnosis
    robot: Robot
    record: Record
    holdout: Record | None
    before: Explanation
    ranking: tuple[RankedCandidate, ...] = ()
    null_probability: float = 0.0
    after: Explanation | None = None
    rival: Explanation | None = None
    patch: tuple[PlacedEffect, ...] = ()
    covariance_of: tuple[str, ...] = ()
    covariance: FloatArray | None = None
    excess: tuple[Excess, ...] = ()
    signals: tuple[SignalGap, ...] = ()
    signature_data: SignatureData | None = None
    tolerance: Mapping[str, float] = field(default_factory=dict)
    limits: tuple[str, ...] = ()
    settings: DiagnosisSettings = field(default_factory=DiagnosisSettings)
    timings: Mapping[str, float] = field(default_factory=dict)

    @property
    def simulated_logs(self) -> int:
        """Simulated logs without a gap that p-values of locations are counted in; 0 where there were none."""
        return self.settings.where.realisations if self.settings.where is not None else 0
