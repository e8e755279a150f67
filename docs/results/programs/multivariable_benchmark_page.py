"""Write multivariable_benchmark.md, or tune a design of it.

python docs/results/programs/multivariable_benchmark_page.py [--tune ROBOT KIND NUMBER]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh

from flexros.benchmark.models import RULES
from flexros.benchmark.multivariable.evaluate import (
    LONG_DELAY,
    LOOP_GAIN,
    SETTLED,
    MotionBenchmark,
    load_motion_controller,
    motion_controller_names,
)
from flexros.benchmark.multivariable.problem import MODELS, PROBLEMS, SEED, SEED_OF_DESIGN, highest, problem_named
from flexros.benchmark.multivariable.tables import motion_demand_rows, motion_rows
from flexros.benchmark.multivariable.tuning import tuned
from flexros.json_text import json_text
from flexros.report.drawing import Drawing, Line, Panel
from flexros.report.theme import run_colour
from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.benchmark.controllers import BenchmarkController
    from flexros.benchmark.multivariable.evaluate import MotionResult
    from flexros.robot import Robot

SETS = ", ".join(
    f"{name} 1 +- {100 * rules.stiffness:g}, {100 * rules.inertia:g} and {100 * rules.losses:g} %"
    for name, rules in RULES.items()
    if rules.stiffness
)
HEAD = f"""# Multivariable benchmark

Written by `python docs/results/programs/multivariable_benchmark_page.py`.
Moberg (2007, section 6.2) asks for a benchmark of
several axes with parametric uncertainty. This is one of ours, by the rules of [that of Paper C](feedback_benchmark.md):
`flexros benchmark --on e12 CONTROLLER.yaml` or `--on six_axis`. **All numbers are chosen.**

A run has a step of a force at the tool, a step of a torque at a motor, a motion under both, chirps at the tool and at a
motor, and a pulse at the tool. The DAE feedforward of the nominal model gives references and torques; the controller
adds the feedback from the motor encoders. Models: the nominal one, and two sets of {MODELS} random ones (seed {SEED};
the designs were tuned on those of seed {SEED_OF_DESIGN}), whose springs, masses and losses are within
{SETS}.

Measures: e, largest distance of the tool from where it was at the start of a window, relative to its undisturbed path
of the nominal model; Ts, until it stays within 0.2 mm (M2: 0.5 mm); peak-to-peak torque at rest about its trend, and
largest torque, in per cent of the motor's. Of a set the worst model counts, measure by measure; mean over two seeds of
the noise.
V_set = 1.259 (sum of e in mm and T in %) + 3.477 (sum of Ts in s); V = 0.6 V_nominal + 1.0 V_M1 + 0.3 V_M2. Demands: Ts
below 1 s, noise torque below 5 %, stable with every model, with {LOOP_GAIN:g} times the loop gain and with
{1e3 * LONG_DELAY:g} ms delay.

Designs: PID and cascade have four numbers (bandwidth, damping ratio, integral gain, filter of the rate) for all axes,
scaled by their inertia at home, tuned by 90 to 200 evaluations that charge 200 for each second beyond the demand on
Ts. State feedback has LQ gains of single axes and no integral action. `coupled_pid` (e12 alone) is a PID with full
gain matrices, so that the error of a motor moves the other one too, and a second-order section per motor; its 21
numbers are searched twice, first for the fastest decay of the slowest motion, then for the cost. LQG (`--tune e12 lqg
100`, four numbers) is not listed: after 100 evaluations its cost was still far above those of the others, because a
filter that trusts the nominal model is hardly stable with the perturbed ones.

Why settling within {SETTLED:g} s is hard: the arm has little damping of its own (its modes with the motors held are
listed below). The motors have to damp it, which a stiff loop does not, and integral action has to be as fast. With the
same few numbers for all axes only the PID of six_axis has both, on its nominal model; with gains of their own between
the motors `coupled_pid` has both on the nominal e12, and nearly on the random models.
"""


def main() -> None:
    """Write the page, or tune one design and print its settings."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--tune", nargs=3, metavar=("ROBOT", "KIND", "NUMBER"), help="tune a design, NUMBER evaluations"
    )
    if tune := parser.parse_args().tune:
        robot, kind, evaluations = tune
        print(json_text(tuned(problem_named(robot), kind, int(evaluations))))
        return
    folder = Path(__file__).parents[1]
    parts = [HEAD]
    for name, problem in PROBLEMS.items():
        bench = MotionBenchmark(problem)
        loaded = [load_motion_controller(problem, one) for one in motion_controller_names(problem)]
        results = sorted((bench.evaluate(one) for one in loaded), key=lambda result: result.cost)
        ranked = [next(one for one in loaded if one.name == result.name) for result in results]
        (folder / "figures" / f"multivariable_benchmark_{name}.svg").write_text(_picture(bench, ranked).svg())
        parts.append(_section(name, results, ranked, bench))
    (folder / "multivariable_benchmark.md").write_text("\n".join(parts))


def _section(
    name: str, results: Sequence[MotionResult], ranked: Sequence[BenchmarkController], bench: MotionBenchmark
) -> str:
    lines = [f"## {name}", ""]
    for result, controller in zip(results, ranked, strict=True):
        missed = [demand.name for demand in result.demands if not demand.passed]
        met = f"{len(result.demands) - len(missed)} of {len(result.demands)} demands met"
        lines.append(f"- `{result.name}` **V = {result.cost:.1f}**: {controller.description}. {met}.")
        if missed:
            lines[-1] += f" Missed: {'; '.join(missed)}."
    modes = [f"{hertz:.3g} Hz ({100 * ratio:.2g} %)" for hertz, ratio in _held_modes(bench.problem.robot)[:3]]
    lines += ["", f"First modes of the arm with the motors held, and their damping ratios: {', '.join(modes)}."]
    best = results[0].measures["M1"]
    windows = problem_named(name).windows
    torque = bench.experiment(ranked[0].nominal).reference.torque
    needed = float(np.max(np.abs(highest(problem_named(name), torque))))
    worst = windows[int(np.argmax(best.deflection))].name
    lines += [
        "",
        f"The best design on M1: largest deflection {np.max(best.deflection):.3g} mm ({worst}; of the nominal model "
        f"{results[0].measures['nominal'].deflection[int(np.argmax(best.deflection))]:.3g} mm), largest torque "
        f"{best.largest_torque:.3g} %, of which the feedforward of the motion is {needed:.3g} %.",
        "",
        f"![Deviation of the tool of the nominal model from its undisturbed path, "
        f"{name}](figures/multivariable_benchmark_{name}.svg)",
        "",
        f"*Distance of the tool of the nominal model from its undisturbed path [mm] over time [s], {name}, with "
        f"noise.*",
        "",
    ]
    names = [result.name for result in results]
    tables = {**motion_rows(results), "demand": motion_demand_rows(results)}
    for heading, rows in tables.items():
        lines += [f"| {heading} | unit | {' | '.join(names)} |", "|---" * (len(names) + 2) + "|"]
        lines += [f"| {row.name} | {row.unit} | {' | '.join(row.values)} |" for row in rows]
        lines.append("")
    return "\n".join(lines)


def _held_modes(robot: Robot) -> list[tuple[float, float]]:
    """Return frequency [Hz] and damping ratio [1] of the modes at home with the motors held."""
    linear = linear_model(robot)
    held = [row for row in range(len(linear.mass)) if row not in robot.motor_rows]
    mass, stiffness, damping = (
        matrix[np.ix_(held, held)] for matrix in (linear.mass, linear.stiffness, linear.damping)
    )
    squares, shapes = eigh(stiffness, mass)
    rates = np.sqrt(squares)
    return list(zip(rates / (2 * np.pi), np.diag(shapes.T @ damping @ shapes) / (2 * rates), strict=True))


def _picture(bench: MotionBenchmark, ranked: Sequence[BenchmarkController]) -> Drawing:
    """Draw the deviation of the tool over time with every design."""
    lines, largest = [], 0.0
    for place, controller in enumerate(ranked):
        run = bench.nominal_run(controller)
        time, distance = run.time, run.distance
        rows = slice(None, None, 16)
        largest = max(largest, float(np.max(distance)))
        lines.append(
            Line(
                np.array(time[rows], dtype=np.float64),
                np.array(distance[rows], dtype=np.float64),
                run_colour(place),
                1.2,
            )
        )
    legend = tuple((one.name, run_colour(place)) for place, one in enumerate(ranked))
    ends = (0.0, float(lines[0].x[-1]))
    panel = Panel("distance [mm] over time [s]", ends, (0.0, 1.05 * largest), tuple(lines), y_log=False)
    return Drawing((panel,), 1, width=700, height=260, legend=legend)


if __name__ == "__main__":
    main()
