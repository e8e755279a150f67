"""Run the study: python -m flexros.identify.study --out FOLDER."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from flexros.errors import FlexrosError
from flexros.identify.study.campaign import run_study
from flexros.identify.study.page import check_folder, write_study
from flexros.identify.study.real_robot import measured_responses, study_scenario, unknowns
from flexros.robot.robot import load_robot


def main(arguments: list[str] | None = None) -> int:
    """Measure the real robot, fit, and write the results.

    Args:
        arguments: Command line; default: that of the process.

    Returns:
        Exit code.
    """
    parser = argparse.ArgumentParser(prog="python -m flexros.identify.study", description=__doc__)
    parser.add_argument("--scenario", default="identify_six_axis", help="robot, excitation and controller")
    parser.add_argument("--positions", type=int, default=15, help="number of positions")
    parser.add_argument("--candidates", type=int, default=2000, help="candidate positions of the design")
    parser.add_argument("--blocks", type=int, default=2, help="blocks of experiments in each position")
    parser.add_argument("--starts", type=int, default=100, help="random starts of each estimator")
    parser.add_argument("--redrawn", type=int, default=100, help="responses drawn anew for the empirical spread")
    parser.add_argument("--seed", type=int, default=1, help="seed of everything that is random")
    parser.add_argument("--scheduler", default="", help="address of a Dask scheduler; default: one in this process")
    parser.add_argument("--out", type=Path, required=True, help="folder for study.md, study.json and pictures")
    try:
        _run(parser.parse_args(arguments))
    except FlexrosError as error:
        Console(stderr=True).print(f"Error: {error}", markup=False, soft_wrap=True)
        return error.exit_code
    return 0


def _run(options: argparse.Namespace) -> None:
    from distributed import Client, LocalCluster  # here, because it loads slowly

    check_folder(options.out)
    scenario = study_scenario(options.scenario, options.positions, options.blocks, options.seed, options.candidates)
    robot = load_robot(scenario.robot)
    with ExitStack() as stack:
        progress = stack.enter_context(Progress(console=Console(stderr=True)))
        task = progress.add_task("measuring", total=None)
        responses = measured_responses(scenario)
        address = options.scheduler or stack.enter_context(
            LocalCluster(processes=False, n_workers=1, dashboard_address=None)
        )
        client = stack.enter_context(Client(address))
        study = run_study(
            robot,
            responses,
            unknowns(robot),
            starts=options.starts,
            seed=options.seed,
            redrawn=options.redrawn,
            client=client,
            progress=lambda name, done, total: progress.update(task, description=name, completed=done, total=total),
        )
    write_study(study, scenario, options.out)


if __name__ == "__main__":
    sys.exit(main())
