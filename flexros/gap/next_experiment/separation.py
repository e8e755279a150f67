"""Separation of two explanations by an experiment: simulated with one, fitted with the other."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.candidates.candidate import Candidate, FreeParameter
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.linearisation import linearise
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.model_probability import contrast_of, form_error
from flexros.gap.settings import DiagnosisSettings
from flexros.identify.design.default_controller import default_controller
from flexros.identify.diagnosis_experiment.course import diagnosis_course
from flexros.record.read import read_record
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.models import ScenarioModels
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedEffect, RobotWithEffects
    from flexros.effects.kinds.ranges import Range
    from flexros.gap.candidates.candidate import Hypothesis
    from flexros.gap.residuals.fit_data import FitData
    from flexros.record.record import Record

ROOM = 30.0
"""Factor by which a fitted parameter may change in either direction when it is fitted again [1] (chosen)."""
WITHOUT_LOG = ("relative", "time", "frequency", "order", "phase")
"""Scales of ranges that are the same for every log."""
ITERATIONS = 6
"""Largest number of iterations of a fit from parameters that were fitted to another log (chosen)."""

LONGEST = 10.0
"""Longest simulated experiment over the length that was asked for [1] (chosen): motors that can hardly accelerate, such
as those of endless inertia, would take days."""


@dataclass(frozen=True, eq=False)
class Explained:
    """An explanation with its parameters, to be simulated and predicted.

    Attributes:
        model: The nominal model.
        placed: Its effects with their fitted parameters.
        settings: Settings of the diagnosis.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; those of the robot file where left out.
        prescribed: Motors of endless inertia, as their motion was prescribed.
    """

    model: RobotWithEffects
    placed: tuple[PlacedEffect, ...]
    settings: DiagnosisSettings = field(default_factory=DiagnosisSettings)
    tolerance: Mapping[str, float] = field(default_factory=dict)
    prescribed: tuple[int, ...] = ()

    @property
    def plant(self) -> RobotWithEffects:
        """The robot if this explanation were true."""
        return self.model.with_effects(self.placed)

    @property
    def hypothesis(self) -> Hypothesis:
        """Its effects with free parameters about the fitted values."""
        return tuple(_candidate(placed, self.model) for placed in self.placed)

    def shared_with(self, other: Explained) -> Explained:
        """Keep only the effects that another explanation has as well."""
        theirs = {(one.effect.name, one.location) for one in other.placed}
        return replace(self, placed=tuple(one for one in self.placed if (one.effect.name, one.location) in theirs))

    def with_values(self, values: Mapping[str, float]) -> Explained:
        """Set known parameters of the nominal robot, e.g. a known load."""
        if not values:
            return self
        robot = self.model.robot.with_values(values, "values of the experiment")
        return replace(self, model=replace(self.model, robot=robot))


@dataclass(frozen=True, eq=False)
class Trial:
    """A simulated experiment with one explanation as the truth.

    Attributes:
        record: The log of the experiment.
        data: The log prepared for a fit.
    """

    record: Record
    data: FitData


def trial(truth: Explained, keys: Mapping[str, Any], seed: int, *, tool: bool = False) -> Trial:
    """Simulate a variant of the diagnosis experiment.

    Args:
        truth: The explanation that is true.
        keys: Keys of scenario `diagnosis` that differ, by dotted name.
        seed: Seed of the experiment and its noise.
        tool: Whether the tool is measured as well.

    Raises:
        DivergedRunError: The run would be aborted.
        InputError: The motors are too slow for such an experiment.
    """
    robot = truth.model.robot
    law = default_controller(robot, robot.sample_time)
    given = {"seed": seed, "controller": {"kind": law.kind, **law.model_dump(mode="json")}, **keys}
    scenario = load_scenario("diagnosis").with_values(given)
    assert scenario.diagnosis is not None
    course = diagnosis_course(
        scenario.diagnosis, robot, scenario.controller, robot.sample_time, scenario.seed, robot.home
    )
    if course.trajectory.duration > LONGEST * scenario.diagnosis.length:
        raise InputError(
            f"the experiment would take {course.trajectory.duration:.4g} s with the motors of robot {robot.name}, not "
            f"{scenario.diagnosis.length:g} s",
            "length",
        )
    experiment = Experiment(
        scenario,
        ScenarioModels(truth.model, truth.model, truth.plant),
        robot.sample_time,
        course.trajectory,
        int(np.floor(course.trajectory.duration / robot.sample_time + 1e-6)) + 1,
    )
    record = read_record(closed_loop(experiment), robot, name="simulated experiment")
    record = record if tool else replace(record, tool=None)
    return Trial(record, fit_data(record, truth.model, truth.settings))


def separation(truth: Explained, rival: Explained, made: Trial) -> float:
    """Compute how much better the truth explains an experiment than its best-fitting rival.

    Model-form errors are treated as in the ranking of explanations.

    Args:
        truth: The explanation that was simulated.
        rival: The other one; its parameters and the tolerated deviations are fitted to the experiment.
        made: The experiment with the truth.

    Returns:
        Logarithm of the odds [nats]; zero where the rival explains the experiment equally well.
    """
    data, sample_time, settings = made.data, made.record.sample_time, made.data.settings
    true_predictor, theta = predictor_of(truth, sample_time)
    rival_predictor, rival_theta = predictor_of(rival, sample_time)
    line = linearise(rival_predictor, data, rival_theta)
    tolerated = line.slopes[:, rival_predictor.n_effect :]  # they are many and change little
    rival_fit = fit(rival_predictor, data, rival_theta, ITERATIONS, tolerance_slopes=tolerated, settings=settings.fit)
    residuals = data.residuals(true_predictor, theta[:, None])
    least = float(np.sum(residuals**2))
    contrast = contrast_of(true_predictor.hypothesis, rival_predictor.hypothesis)
    distance = None
    if contrast.between:
        distance = float(np.sum((residuals - data.residuals(rival_predictor, rival_fit.theta[:, None])) ** 2))
    shared_predictor, shared_theta = predictor_of(truth.shared_with(rival), sample_time)
    most = float(chi2_of(shared_predictor, data, shared_theta[:, None])[0])
    error = form_error(max(most - least, 0.0), plain=contrast.plain, distance=distance, settings=settings.ranking)
    return max(rival_fit.chi2 - least, 0.0) / (2.0 + error)


def predictor_of(explained: Explained, sample_time: float) -> tuple[Predictor, FloatArray]:
    """Build the predictor of an explanation.

    Args:
        explained: The explanation.
        sample_time: Time between two samples [s].

    Returns:
        Predictor, and the encoded parameters at which it has the fitted values, shape (n_fitted,).
    """
    hypothesis = explained.hypothesis
    tolerance = tolerance_of(explained.model.robot, explained.tolerance, explained.prescribed)
    theta = [parameter.encode(parameter.starts[0]) for candidate in hypothesis for parameter in candidate.free]
    theta += [0.0] * len(tolerance.names)
    return Predictor(explained.model, hypothesis, tolerance, sample_time), np.array(theta, dtype=float)


def _candidate(placed: PlacedEffect, model: RobotWithEffects) -> Candidate:
    """Free the parameters of an effect that have a range, about their values."""
    values = placed.effect.model_dump()
    there = [law.effect for law in model.laws if law.location == placed.location]
    nominal = placed.effect.reductions(model.robot, placed.location, there)
    ways = [way for way in placed.effect.harmonics if all(values[name] == value for name, value in way.fixed)]
    largest = min((way.largest for way in ways), default=np.inf)
    free = tuple(
        _free(name, float(values[name]), allowed, nominal.get(name, 0.0), largest if name == "amplitude" else np.inf)
        for name, allowed in placed.effect.ranges.items()
        if values.get(name)
    )
    fixed = tuple((name, value) for name, value in values.items() if name not in {one.name for one in free})
    return Candidate(type(placed.effect), placed.location, free, fixed)


def _free(name: str, value: float, allowed: Range, nominal: float = 0.0, largest: float = np.inf) -> FreeParameter:
    """Free a parameter about its value, within its range where that does not depend on the log.

    One that takes from a nominal number of the robot takes no more than that, and one may have a largest value.
    """
    size, reduces = abs(value), value < 0.0 and not allowed.signed
    low, high, negative = size / ROOM, min(size * ROOM, max(largest, size)), None
    if allowed.scale in WITHOUT_LOG:
        low, high = max(low, min(allowed.low, size)), min(high, max(allowed.high, size))
        negative = None if allowed.negative is None else min(high, max(allowed.negative, -value))
    if reduces:
        negative = min(high, max(nominal, size))
    return FreeParameter(name, low, high, allowed.signed or reduces, (value,), negative, vanishes=allowed.vanishes)
