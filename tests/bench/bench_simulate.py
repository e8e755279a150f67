"""Speed of the closed loop compared with MuJoCo, SciPy and the CasADi virtual machine, measured in the same run.

Prints a JSON list of rows. Every engine runs the same loop: robot at rest, PD on the motor positions with
feedforward torque that moves it, one Runge-Kutta step per sample where the engine has fixed steps.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import solve_ivp

from flexros.compile.compiled_function import compile_function
from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import LoopKernel, compile_loop
from flexros.control.context import LoopContext
from flexros.control.controller import Controller
from flexros.control.pid import Pid
from flexros.robot import Robot, load_robot
from flexros.scenario.batch import batch
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from flexros.simulate.plant import Plant, delayed_start
from flexros.simulate.plant_model import PlantModel
from tests.oracles.mujoco_model import mujoco_closed_loop

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from flexros.arrays import FloatArray

T = 5e-4
GOAL_NS = {("e12", 1): 250.0, ("e12", 8): 35.0, ("six_axis", 1): 4000.0, ("six_axis", 8): 500.0}


@dataclass(frozen=True)
class Case:
    """A robot under PD, pushed by a sine of feedforward torque."""

    name: str
    robot: Robot
    law: Pid
    state: FloatArray
    holding: FloatArray

    @classmethod
    def of(cls, name: str) -> Case:
        robot = load_robot(name)
        law = load_scenario({"e12": "circle_pd", "six_axis": "six_axis_moves"}[name]).controller
        assert isinstance(law, Pid)
        pd = law.model_copy(update={"ki": 0.0, "derivative_filter": 0.0})
        state = robot.equilibrium()
        return cls(name, robot, pd, state, robot.holding_torque(state))

    @property
    def context(self) -> LoopContext:
        """Context of the control law."""
        return LoopContext(self.robot, T)

    @property
    def gains(self) -> FloatArray:
        """Gains without a torque limit, which the peers do not have."""
        gains = self.law.gains(self.context)
        return np.where(np.arange(len(gains)) < len(gains) - self.robot.n_motors, gains, np.inf)

    def references(self, n: int) -> FloatArray:
        motors = self.robot.n_motors
        position = self.robot.model.encoder(self.state[: self.robot.n_coordinates]).full().ravel()
        push = 0.02 * self.gains[:motors]
        sine = np.sin(2 * np.pi * 2.0 * T * np.arange(n))[:, None] * push
        return np.hstack([np.tile(position, (n, 1)), np.zeros((n, motors)), self.holding + sine])

    def kernel(self, lanes: int, engine: Any = "machine_code") -> LoopKernel:
        controller = self.law.function(self.context)
        functions = PlantModel(self.robot).functions(controller)
        return compile_loop(functions, sample_time=T, lanes=lanes, engine=engine)

    def run(self, kernel: LoopKernel, references: FloatArray) -> FloatArray:
        motors = self.robot.n_motors
        start = delayed_start(self.state, self.law.initial_state(self.context), np.zeros(motors), kernel.line_length)
        inputs = LoopInputs(reference=references, gains=self.gains)
        result = kernel.run(start, len(references), inputs, record_pose=False)
        return result.final.plant


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Return the shortest time of several runs [s]; other load on the machine only increases it."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def loop_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time one closed-loop step, alone and on lanes."""
    n = 10_000 if case.name == "e12" else 1000
    references = case.references(n)
    for lanes in (1, 8):
        begin = time.perf_counter()
        kernel = case.kernel(lanes)
        case.run(kernel, references[:1])
        yield row(case.name, f"first result, {lanes} lanes", time.perf_counter() - begin, "s", 0.5)
        took = seconds(partial(case.run, kernel, references), 40)
        what = "closed-loop step" if lanes == 1 else f"closed-loop step per lane, {lanes} lanes"
        yield row(case.name, what, 1e9 * took / (n * lanes), "ns", GOAL_NS[case.name, lanes])


def peer_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time the same loop with the peers, and say how far their states are from ours."""
    n = 1000
    references, motors = case.references(n), case.robot.n_motors
    ours = case.run(case.kernel(1), references)[: case.robot.n_coordinates]
    kernel = case.kernel(1, "virtual_machine")
    case.run(kernel, references)
    took = seconds(lambda: case.run(kernel, references), 3)
    yield row(case.name, "closed-loop step, CasADi virtual machine", 1e9 * took / n, "ns")

    gains = case.gains
    short = np.hstack([references[:, :motors], references[:, 2 * motors :]])
    kp, kd = gains[:motors], gains[2 * motors : 3 * motors]
    arguments = (case.robot, case.state, np.vstack([short, short[-1:]]), kp, kd, T)
    coordinates = mujoco_closed_loop(*arguments)
    took = seconds(lambda: mujoco_closed_loop(*arguments), 3)
    yield row(case.name, "closed-loop step, MuJoCo RK4", 1e9 * took / n, "ns")
    apart = float(np.max(np.abs(coordinates[-1] - ours)))
    yield row(case.name, "largest difference to MuJoCo after 0.5 s", apart, "rad")

    steps = 100
    theirs = dop853(case, references[:steps])
    took = seconds(lambda: dop853(case, references[:steps]), 2)
    yield row(case.name, "closed-loop step, SciPy DOP853", 1e9 * took / steps, "ns")
    apart = float(np.max(np.abs(theirs - case.run(case.kernel(1), references[:steps]))))
    yield row(case.name, "largest difference to DOP853 after 0.05 s", apart, "rad, rad/s")


def dop853(case: Case, references: FloatArray) -> FloatArray:
    """Run the loop with SciPy's eighth-order solver on the compiled derivative, sample by sample."""
    nq = case.robot.n_coordinates
    derivative = compile_function(case.robot.model.derivative)
    controller = Controller(case.law, case.context)
    x, rest = case.state, np.zeros(6)
    for reference in references:
        u = controller.step(case.robot.model.encoder(x[:nq]).full().ravel(), reference)

        def rate(_t: float, state: FloatArray, u: FloatArray = u) -> FloatArray:
            return derivative(state, u, rest, np.zeros(0))[0]

        x = solve_ivp(rate, (0.0, T), x, "DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    return np.asarray(x)


def node_rows(case: Case) -> Iterator[dict[str, Any]]:
    """Time what the nodes do per sample."""
    plant, controller = Plant(case.robot, T, case.state, noise=True), Controller(case.law, case.context)
    reference = case.references(1)[0]

    def step() -> None:
        for _ in range(500):
            command = controller.step(plant.measure(), reference)
            plant.tool_pose()
            plant.advance(command)

    yield row(case.name, "plant and controller, one sample, noise on", 1e6 * seconds(step, 20) / 500, "us")


def batch_rows() -> Iterator[dict[str, Any]]:
    """Time a load sweep of the circle test on all processors."""
    experiment = Experiment.prepare(load_scenario("circle_dae"))
    masses, n = np.linspace(190, 210, 512), experiment.n_samples
    values = {"body_3.mass": masses}
    took = seconds(lambda: batch(experiment, lambda record: record.diverged, values=values), 3)
    yield row("e12", "load sweep of 512 runs, starts and compilation included", 1e3 * took, "ms")
    yield row("e12", "the same per closed-loop step", 1e9 * took / (512 * n), "ns")
    seeds = range(512)
    took = seconds(lambda: batch(experiment, lambda record: record.diverged, seeds=seeds), 3)
    yield row("e12", "512 runs of one plant per closed-loop step", 1e9 * took / (512 * n), "ns")


def row(case: str, what: str, value: float, unit: str, goal: float | None = None) -> dict[str, Any]:
    """Return one row of the results."""
    return {"case": case, "what": what, "value": float(f"{value:.4g}"), "unit": unit, "goal": goal}


def main() -> None:
    """Print all rows as one JSON list."""
    rows: list[dict[str, Any]] = []
    for case in (Case.of("e12"), Case.of("six_axis")):
        for part in (loop_rows, peer_rows, node_rows):
            rows += part(case)
    rows += batch_rows()
    print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
