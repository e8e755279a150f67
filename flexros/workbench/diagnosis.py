"""Gap between a recorded robot and its model: its size, its causes, its repair."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexros.effects.patching.patched_robot import load_patched
from flexros.errors import InputError, unknown_name
from flexros.gap.candidates.tolerance import KINDS
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose as diagnosed
from flexros.gap.held_out.closed_loop_gap import measured_alone
from flexros.gap.measure_gap import MeasuredGap
from flexros.gap.measure_gap import measure_gap as measured
from flexros.gap.settings import DiagnosisSettings, SearchSettings
from flexros.workbench.given import log_of, model_of, name_of, reference_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import pandas as pd
    import plotly.graph_objects as go

    from flexros.effects import RobotWithEffects
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import Cause, GapNumbers
    from flexros.gap.schema import Diagnosis as Answer
    from flexros.record.topic_reader import TorqueSource
    from flexros.workbench.given import GivenLog, GivenModel

PICTURES = ("budget", "gap")
"""Pictures of a diagnosis."""


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis:
    """Diagnosis of a log: where the gap shows, which effects cause it, how far they close it.

    Attributes:
        result: All that the diagnosis computed, as its report shows it.
        model: The model that was diagnosed, as given.
    """

    result: DiagnosisResult
    model: GivenModel

    @property
    def answer(self) -> Answer:
        """The content of diagnosis.json."""
        return self.result.diagnosis

    @property
    def verdict(self) -> str:
        """One of no_gap, explained, partly_explained, ambiguous, unknown_effect."""
        return self.answer.verdict

    @property
    def causes(self) -> tuple[Cause, ...]:
        """Effects that are probably part of the truth, what closes most of the held-out gap first."""
        return self.answer.causes

    @property
    def gap(self) -> GapNumbers:
        """The gap on held-out data, before and after the repair."""
        return self.answer.gap

    @cached_property
    def repaired(self) -> RobotWithEffects:
        """The model with the effects that repair it: give it as `model` to any other function."""
        return model_of(self.model).with_effects(self.result.patch)

    def as_dict(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        return self.answer.model_dump(mode="json", by_alias=True)

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each parameter of each cause: value, std, unit, probability and closed fraction."""
        import pandas as pd

        rows = [
            {
                "effect": cause.effect,
                "location": cause.location,
                "parameter": name,
                "value": entry.value,
                "std": entry.std,
                "unit": entry.unit,
                "probability": cause.probability,
                "closed_fraction": cause.closed_fraction,
            }
            for cause in self.causes
            for name, entry in cause.parameters.items()
        ]
        columns = ("effect", "location", "parameter", "value", "std", "unit", "probability", "closed_fraction")
        return pd.DataFrame(rows, columns=list(columns)).set_index(["effect", "location", "parameter"])

    def plot(self, what: str = "") -> go.Figure:
        """Draw the budget of the gap at each joint, or the gap before and after the repair.

        Args:
            what: "budget" or "gap"; empty for the budget where there is one.

        Raises:
            InputError: Another word, or no effect was found, so that there is no budget.
        """
        from flexros.gap.report.how_far import gap_figure
        from flexros.gap.report.waterfall import shown, waterfall_figure

        if what and what not in PICTURES:
            raise unknown_name("picture", what, PICTURES)
        if what == "budget" and not shown(self.answer):
            raise InputError("no effect was found, so the gap has no budget; draw 'gap'", "what")
        return waterfall_figure(self.answer) if what != "gap" and shown(self.answer) else gap_figure(self.gap)

    def write(self, folder: str | Path) -> tuple[Path, ...]:
        """Write diagnosis.json, report.html and, where there is anything to repair, patch.yaml.

        Args:
            folder: A new or empty folder, or that of an earlier diagnosis, which is replaced.

        Returns:
            The files.

        Raises:
            InputError: The folder may not be replaced, or the model was changed in this process and has no file.
        """
        from flexros.gap.report.files import write_diagnosis

        return tuple(
            Path(folder) / name for name in write_diagnosis(self.result, reference_of(self.model), Path(folder))
        )

    def __repr__(self) -> str:
        from flexros.gap.report.terminal import verdict_line

        return f"<Diagnosis, {verdict_line(self.answer)}>"

    def _repr_html_(self) -> str:
        from flexros.gap.report.write import diagnosis_html

        return diagnosis_html(self.result)


def diagnose(
    log: GivenLog,
    model: GivenModel,
    *,
    holdout: GivenLog | None = None,
    tolerance: Mapping[str, float] | None = None,
    torque: TorqueSource = "command",
    prescribed: Sequence[str] = (),
    joints: Sequence[str] = (),
    effects: Sequence[str] = (),
    time_limit: float | None = None,
    settings: DiagnosisSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Diagnosis:
    """Diagnose the gap between a recorded robot and its model.

    Args:
        log: Log that effects are fitted to: a log, a run, or a path.
        model: The nominal robot: built-in name, path of a robot file or of a patch, or a robot.
        holdout: Held-out log, read once at the end; default: the last third of `log`.
        tolerance: Relative tolerance (one standard deviation) of stiffness, inertia and damping [1], e.g.
            {"stiffness": 0.03}; default: those of the robot file. "torque" is that of the torques of an imported log,
            as a share of their rms; default: 0.05.
        torque: Torque that is used where both were recorded: "command" or "measured".
        prescribed: Motors without a usable torque, whose measured motion drives the model.
        joints: Motors at which effects compete, with their springs and bodies; default: all.
        effects: Names of the effects that compete; default: all.
        time_limit: Time in which an answer must be found, however incomplete [s]; default: none.
        settings: All settings, instead of `joints`, `effects` and `time_limit`.
        progress: Called with the name of the stage and the share of all that is done [1].

    Returns:
        Verdict, causes, budget; `repaired` is the repaired model, `write` makes diagnosis.json, patch.yaml and report.

    Raises:
        InputError: A log from which nothing can be concluded, or unknown names.
    """
    known = model_of(model)
    _check_tolerance(tolerance)
    if settings is None:
        search = SearchSettings(effects=tuple(effects), joints=tuple(joints))
        settings = DiagnosisSettings(time_limit=time_limit, search=search)
    records = []
    for number, one in enumerate((log, holdout), 1):
        if one is not None:
            read = log_of(one)
            name, second = name_of(one, number), number == 2
            records.append(
                checked_log(read, known.robot, name=name, torque=torque, prescribed=prescribed, held_out=second)
            )
            read = measured_alone(read)
    result = diagnosed(
        records[0],
        known,
        holdout=records[1] if holdout is not None else None,
        log=read,
        tolerance=tolerance,
        settings=settings,
        progress=progress,
    )
    return Diagnosis(result, model)


def measure_gap(
    log: GivenLog,
    model: GivenModel,
    *,
    repaired: GivenModel | None = None,
    tolerance: Mapping[str, float] | None = None,
    torque: TorqueSource = "command",
    prescribed: Sequence[str] = (),
    settings: DiagnosisSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> MeasuredGap:
    """Measure the gap between a model and a log: prediction errors 0.1 s ahead over their noise floor.

    Args:
        log: A log, a run, or a path.
        model: The nominal robot: built-in name, path of a robot file or of a patch, or a robot.
        repaired: The same with effects on it: a patch, or `Diagnosis.repaired`; default: the nominal one alone.
        tolerance: Relative tolerance of stiffness, inertia, damping and torque [1], as for `diagnose`.
        torque: Torque that is used where both were recorded: "command" or "measured".
        prescribed: Motors without a usable torque, whose measured motion drives the model.
        settings: Settings of the diagnosis.
        progress: Called with the name of the stage and the share of all that is done [1].

    Returns:
        `numbers`, and whether the model, the repaired one where there is one, leaves a `significant` gap.

    Raises:
        InputError: A log from which nothing can be concluded, or a patch of another robot.
    """
    known = model_of(model)
    _check_tolerance(tolerance)
    if isinstance(model, (str, Path)) and isinstance(repaired, (str, Path)):
        _check_patch(model, repaired)
    record = checked_log(log_of(log), known.robot, name=name_of(log), torque=torque, prescribed=prescribed)
    better = None if repaired is None else model_of(repaired)
    return measured(record, known, repaired=better, tolerance=tolerance, settings=settings, progress=progress)


def _check_patch(model: str | Path, patch: str | Path) -> None:
    """Refuse a patch of another model: before and after would refer to two robots."""
    nominal, patched = load_patched(model), load_patched(patch)
    if patched.base.model_hash != nominal.base.model_hash or patched.placed[: len(nominal.placed)] != nominal.placed:
        raise InputError(f"{patch} is on top of {patched.base.name}, not of {model}; give that model", "repaired")


def _check_tolerance(tolerance: Mapping[str, float] | None) -> None:
    for kind, value in (tolerance or {}).items():
        if kind not in KINDS:
            raise unknown_name("kind", kind, KINDS, "tolerance")
        if not 0 <= value < 1:
            raise InputError(
                f"the tolerance of {kind} is {value}, allowed are relative deviations from 0 to below 1; correct it",
                "tolerance",
            )
