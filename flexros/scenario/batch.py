"""Many runs at once, with sets of plant parameters, gains and seeds, on SIMD lanes and threads."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import LoopKernel, compile_loop
from flexros.effects.patching.placement import check_levels
from flexros.errors import InputError, unknown_name
from flexros.robot.equilibrium_search import Equilibrium
from flexros.simulate.plant import delayed_start
from flexros.simulate.plant_model import PlantModel
from flexros.simulate.sample_blocks import Zeros

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import ArrayLike

    from flexros.arrays import FloatArray
    from flexros.compile.loop.arrays import LoopResult
    from flexros.scenario.experiment import Experiment
    from flexros.simulate.sample_blocks import SampleBlocks

LANES = 8
"""Largest number of runs in parallel lanes of one thread: the width of the widest vector registers [1]."""

Figure = TypeVar("Figure")


@dataclass(frozen=True, eq=False)
class RunRecord:
    """Signals of one run of a batch.

    Attributes:
        encoder: Measured motor positions [rad or m], shape (n, M).
        command: Torque commands [Nm or N], shape (n, M).
        tool_pose: Measured tool pose, position [m] and quaternion x, y, z, w, shape (n, 7).
        diverged: Sample at which the state became infinite and the arrays end; -1 for none.
    """

    encoder: FloatArray
    command: FloatArray
    tool_pose: FloatArray
    diverged: int


@dataclass(frozen=True, eq=False)
class BatchSets:
    """Parameters, gains, seeds and initial states of all runs.

    Attributes:
        names: Plant parameters that differ between runs.
        parameters: Their values (SI), shape (n_runs, n_parameters).
        gains: All gains of the controller, shape (n_runs, n_gains).
        seeds: Seeds, length n_runs.
        equilibria: Initial equilibria of the plants, length n_runs.
    """

    names: tuple[str, ...]
    parameters: FloatArray
    gains: FloatArray
    seeds: tuple[int, ...]
    equilibria: tuple[Equilibrium, ...]

    def __len__(self) -> int:
        return len(self.seeds)


def whole_record(record: RunRecord) -> RunRecord:
    """Return all signals of a run, for `figure` of `batch`."""
    return record


def batch(
    experiment: Experiment,
    figure: Callable[[RunRecord], Figure],
    *,
    values: Mapping[str, ArrayLike] | None = None,
    gains: Mapping[str, ArrayLike] | None = None,
    seeds: Sequence[int] | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[Figure]:
    """Run an experiment with many sets of values; all share its reference.

    Args:
        experiment: The experiment.
        figure: Result of each run, computed when it ends; `whole_record` keeps all signals.
        values: Parameter of the plant -> its value in every run (SI), each of shape (n_runs,); of the robot, e.g.
            "body_3.mass", or of an effect in the scenario, e.g. "coulomb_friction@motor_1.level".
        gains: Gain by the names of the control law, e.g. "motor_1.kp" -> its value in every run, shape (n_runs,).
        seeds: Seed of noise and random disturbances in every run; default: that of the scenario in all.
        threads: Number of threads; default: one per processor.
        progress: Called repeatedly with the number of completed runs.

    Returns:
        The results of all runs, in order; a run that diverges does not affect the others.

    Raises:
        InputError: Unknown names, or different numbers of values.
    """
    model = PlantModel(experiment.plant, experiment.laws, tuple(values or ()), sensors=experiment.plant.further_sensors)
    sets = batch_sets(experiment, model, values or {}, gains or {}, seeds)
    lanes = min(LANES, 1 << (len(sets) - 1).bit_length())
    kernel = compile_loop(
        model.functions(experiment.control_function),
        sample_time=experiment.sample_time,
        substeps=experiment.scenario.substeps,
        delay=model.delay,
        lanes=lanes,
    )
    _ = experiment.reference_signal  # computed once, before the threads use it
    groups = [range(first, min(first + lanes, len(sets))) for first in range(0, len(sets), lanes)]
    figures: dict[int, Figure] = {}
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        jobs = [pool.submit(_run_group, experiment, figure, kernel, model, sets, group) for group in groups]
        try:
            for job in as_completed(jobs):
                figures |= job.result()
                if progress is not None:
                    progress(len(figures))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [figures[run] for run in range(len(sets))]


def batch_sets(
    experiment: Experiment,
    model: PlantModel,
    values: Mapping[str, ArrayLike],
    gains: Mapping[str, ArrayLike],
    seeds: Sequence[int] | None,
) -> BatchSets:
    """Build the arrays of all runs, and check that they have one length; see `batch`."""
    arrays = {f"values of {name}": np.asarray(given, dtype=float) for name, given in values.items()}
    arrays |= {f"gains {name}": np.asarray(given, dtype=float) for name, given in gains.items()}
    if seeds is not None:
        arrays["seeds"] = np.asarray(seeds, dtype=float)
    for name, array in arrays.items():
        if array.ndim != 1 or not np.all(np.isfinite(array)):
            raise InputError(f"batch: {name} are {array.tolist()}, allowed is one finite number for each run")
    lengths = {name: len(array) for name, array in arrays.items()}
    if len(set(lengths.values())) != 1 or 0 in lengths.values():
        given = ", ".join(f"{length} {name}" for name, length in lengths.items()) or "nothing"
        raise InputError(f"batch: {given} were given, allowed is the same number for all, at least one")
    n_runs = next(iter(lengths.values()))
    law = experiment.scenario.controller
    gain_names = law.gain_names(experiment.loop_context)
    all_gains = np.tile(experiment.gains, (n_runs, 1))
    for name in gains:
        if name not in gain_names:
            raise unknown_name(f"gain of controller {law.kind}", name, gain_names, "the batch")
        all_gains[:, gain_names.index(name)] = arrays[f"gains {name}"]
    parameters = np.array([arrays[f"values of {name}"] for name in values]).reshape(len(values), n_runs).T
    random = experiment.scenario.noise or experiment.scenario.disturbances
    own_seeds = (
        (experiment.scenario.seed,) * n_runs if seeds is None or not random else tuple(int(seed) for seed in seeds)
    )
    return BatchSets(tuple(values), parameters, all_gains, own_seeds, _equilibria(experiment, model, parameters))


def _equilibria(experiment: Experiment, model: PlantModel, parameters: FloatArray) -> tuple[Equilibrium, ...]:
    """Compute the initial state of every plant; smallest and largest value of each parameter must be physical."""
    start = Equilibrium(experiment.start_state, experiment.start_torque)
    if not model.parameter_names:
        return (start,) * len(parameters)
    of_robot = [model.parameter_names[column] for column in model.robot_columns]
    for name, column in zip(model.parameter_names, parameters.T, strict=True):
        for run in {int(np.argmin(column)), int(np.argmax(column))}:
            value, source = {name: float(column[run])}, f"run {run} of the batch"
            experiment.plant.with_values(value if name in of_robot else {}, source)
            check_levels([law.with_values(value, source) for law in model.laws], source)
    equilibria = []
    for values in parameters:
        rest = model.rest(start.state, values)
        equilibria.append(Equilibrium(rest.state, model.command_at_rest(rest.state, rest.torque, values)))
    return tuple(equilibria)


def _run_group(
    experiment: Experiment,
    figure: Callable[[RunRecord], Figure],
    kernel: LoopKernel,
    model: PlantModel,
    sets: BatchSets,
    group: range,
) -> dict[int, Figure]:
    """Run one set per lane, with the last one repeated to fill the lanes."""
    members = [*group, *[group[-1]] * (kernel.lanes - len(group))]
    n = experiment.n_samples
    equilibria = [sets.equilibria[run] for run in members]
    of_seed = {seed: experiment.signals(seed) for seed in dict.fromkeys(sets.seeds[run] for run in members)}
    signals = [of_seed[sets.seeds[run]] for run in members]
    result = kernel.run(
        delayed_start(
            _lanes(
                [model.start(rest.state, rest.torque, sets.parameters[run]) for run, rest in zip(members, equilibria)]
            ),
            experiment.control_state,
            _lanes([rest.torque for rest in equilibria]),
            kernel.line_length,
        ),
        n,
        LoopInputs(
            reference=experiment.reference_signal,
            noise=_signal([signal.measurement_errors for signal in signals], n),
            disturbance=_signal([signal.disturbance for signal in signals], n),
            parameters=_lanes([sets.parameters[run] for run in members]),
            gains=_lanes([sets.gains[run] for run in members]),
        ),
    )
    return {
        run: figure(_record(result, lane, kernel.lanes, signals[lane].tool_noise)) for lane, run in enumerate(group)
    }


def _record(result: LoopResult, lane: int, lanes: int, tool_noise: SampleBlocks) -> RunRecord:
    """Return the signals of one lane up to its divergence."""
    assert result.tool_pose is not None
    pick = ... if lanes == 1 else (..., lane)
    diverged = int(result.diverged[pick])
    end = len(result.encoder) if diverged < 0 else diverged
    signals = (result.encoder, result.command, result.tool_pose)
    encoder, command, pose = (np.array(signal[pick][:end]) for signal in signals)
    if not isinstance(tool_noise, Zeros):
        pose[:, :3] += tool_noise.rows(0, end)
    return RunRecord(encoder, command, pose, diverged)


def _lanes(columns: Sequence[FloatArray]) -> FloatArray:
    """Stack vectors of the lanes, shape (size, lanes), or (size,) for one lane."""
    return columns[0] if len(columns) == 1 else np.stack(columns, axis=-1)


def _signal(lanes: list[SampleBlocks], n: int) -> FloatArray | None:
    """Stack signals of the lanes, shape (n, width, lanes); (n, width) if all share one, None for zero."""
    if all(isinstance(signal, Zeros) for signal in lanes):
        return None
    if all(signal is lanes[0] for signal in lanes):
        return lanes[0].rows(0, n)
    return np.stack([signal.rows(0, n) for signal in lanes], axis=-1)
