"""Simulator of the blind check, with equations, regularisations and time steps of its own.

Many integration steps per sample (30 us each), accelerations from a factorisation of the mass matrix, friction by stiff
bristles, hysteresis by Bouc-Wen, springs with rounded corners, commands at their exact times: not the numerics by which
a diagnosis predicts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.compile import LoopFunctions, LoopInputs, LoopState, compile_loop
from flexros.control.context import LoopContext
from flexros.errors import RunError
from flexros.validation.blind.plant.added_mode import with_mode
from flexros.validation.blind.plant.equations import Equations
from flexros.validation.blind.plant.laws import LAWS
from flexros.validation.blind.plant.multirate import MultirateLoop
from flexros.validation.blind.plant.replay import corrected

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.robot import Robot
    from flexros.validation.blind.deviation import Deviation
    from flexros.validation.blind.plant.replay import Correction

TICK = 31.25e-6
"""Largest step of the integration [s]; 16 per sample of 0.5 ms (chosen)."""
LONGEST_DELAY = 8e-3
"""Longest delay of a command in addition to that of the robot [s] (chosen)."""
_SLICE = 2000


class UnstableCaseError(RunError):
    """The closed loop of a case ran away."""


@dataclass(frozen=True, eq=False)
class BlindInputs:
    """Signals of a run, one row per sample.

    Attributes:
        reference: Motor positions, speeds and feedforward torques, shape (n, 3 M).
        noise: Encoder noise [rad or m], shape (n, M).
        late: How much later than its stamp each position was read [s], shape (n, M).
        lost: 1 where the command is lost, shape (n,).
        push: Push from outside [1], shape (n,).
    """

    reference: FloatArray
    noise: FloatArray
    late: FloatArray
    lost: FloatArray
    push: FloatArray

    def rows(self) -> FloatArray:
        """Put all signals side by side, shape (n, 5 M + 2)."""
        return np.column_stack([self.reference, self.noise, self.late, self.lost, self.push])


@dataclass(frozen=True, eq=False)
class BlindRun:
    """Result of a simulated run.

    Attributes:
        encoder: Encoder values [rad or m], shape (n, M).
        command: Commands of the controller [Nm or N], shape (n, M).
        states: True coordinates and rates of the simulated robot at the samples, shape (n, 2 n_coordinates).
    """

    encoder: FloatArray
    command: FloatArray
    states: FloatArray


class BlindPlant:
    """A robot with deviations in closed loop; compiled once, run with any parameters.

    Args:
        robot: The robot without deviations.
        deviations: Deviations; their numbers are those used where `run` is given no others.
        law: Control law.
        sample_time: Time between two samples [s].
        tick: Largest step of the integration [s].
        correction: Gain by which the plant follows recorded positions, given as those of the reference; none: it runs
            freely.
    """

    def __init__(
        self,
        robot: Robot,
        deviations: Sequence[Deviation],
        law: AbstractControlLaw,
        sample_time: float,
        tick: float = TICK,
        correction: Correction | None = None,
    ) -> None:
        self.nominal, self.deviations, self.law = robot, tuple(deviations), law
        self.sample_time = sample_time
        self._context = LoopContext(robot, sample_time)
        self.ticks = math.ceil(sample_time / tick - 1e-9)
        self.robot, first_body = _robot_with_modes(robot, self.deviations)
        plant = Equations(self.robot, len(robot.spec.bodies), sample_time / self.ticks, first_body)
        names = [(at, name) for at, one in enumerate(self.deviations) for name in one.parameters]
        self._numbers = ca.SX.sym("numbers", len(names))
        symbols: list[dict[str, ca.SX]] = [{} for _ in self.deviations]
        for place, (at, name) in enumerate(names):
            symbols[at][name] = self._numbers[place]
        for one, values in zip(self.deviations, symbols, strict=True):
            LAWS[one.effect](plant, one.location, values)
        self._plant = plant
        self._correction = None if correction is None else correction(self.robot)
        delays = [robot.delay + extra for extra in plant.delays]
        slow = any(one.effect == "delay" for one in self.deviations)
        longest = robot.delay + (LONGEST_DELAY if slow else 0.0)
        m, places = robot.n_motors, self.robot.motor_rows
        self._loop = MultirateLoop(
            law.function(self._context), m, sample_time, self.ticks, math.ceil(longest / sample_time - 1e-9),
            delays, plant.readings, self._numbers, plant.q, places,
        )  # fmt: skip
        self._kernel = compile_loop(self._functions(), sample_time=sample_time / self.ticks)

    def _functions(self) -> LoopFunctions:
        plant, nq, m = self._plant, self.robot.n_coordinates, self.robot.n_motors
        inner = ca.vertcat(ca.SX(0, 1), *[state.symbol for state in plant.states])
        x = ca.vertcat(plant.q, plant.v, inner, plant.time)
        rates = [ca.SX(0) if state.rate is None else state.rate for state in plant.states]
        loop, push = self._loop.function(), ca.SX.sym("correction", 0)
        rate = ca.vertcat(plant.v, plant.acceleration())
        if self._correction is not None:
            loop = corrected(loop, self._correction, m, slice(0, m))
            push = ca.SX.sym("correction", len(self._correction))
            rate += push * (self.ticks / self.sample_time)
        derivative = ca.vertcat(rate, *rates, 1)
        u = ca.vertcat(plant.command, ca.SX.sym("unused", 2 * m), plant.push, push)
        updates = [state.symbol if state.update is None else state.update for state in plant.states]
        after = ca.vertcat(plant.q, plant.v, *updates, plant.time)
        arguments = [x, u, plant.wrench, self._numbers]
        dummy = ca.SX.sym("p", self._numbers.numel())
        places = list(self.robot.motor_rows)
        seen = ca.vertcat(plant.q[places], plant.v[places], ca.SX.zeros(m + 1 + push.numel()))
        return LoopFunctions(
            derivative=ca.Function("derivative", arguments, [ca.densify(derivative)], {"cse": True}),
            encoder=ca.Function("encoder", [x[: 2 * nq]], [ca.densify(seen)]),
            tool_pose=ca.Function("tool_pose", [plant.q, dummy], [ca.DM.zeros(7, 1)]),
            controller=loop,
            exact_update=ca.Function("update", [*arguments, plant.step], [ca.densify(after)], {"cse": True})
            if any(state.update is not None for state in plant.states)
            else None,
        )

    def numbers(self, deviations: Sequence[Deviation] | None = None) -> FloatArray:
        """Return the parameters of deviations in the order of the compiled plant, shape (P,)."""
        chosen = self.deviations if deviations is None else deviations
        return np.array([value for one in chosen for value in one.parameters.values()], dtype=float)

    def run(self, inputs: BlindInputs, settle: float = 0.0, deviations: Sequence[Deviation] | None = None) -> BlindRun:
        """Simulate.

        Args:
            inputs: Signals; the run starts at rest where the reference starts.
            settle: Time before the first sample during which the reference is at rest [s].
            deviations: The same deviations with other numbers; not for those that add a body.

        Returns:
            What happened from the first sample on.

        Raises:
            UnstableCaseError: The loop ran away.
        """
        lead = round(settle / self.sample_time)
        rows = inputs.rows()
        before = np.repeat(rows[:1], lead, axis=0)
        before[:, self.robot.n_motors : 2 * self.robot.n_motors] = 0.0
        rows = np.concatenate([before, rows])
        numbers = self.numbers(deviations)
        gains = np.concatenate([self.law.gains(self._context), numbers])
        state = self._start(inputs, -lead * self.sample_time)
        found: list[FloatArray] = []
        nq, m = self.robot.n_coordinates, self.robot.n_motors
        for first in range(0, len(rows), _SLICE):
            part = rows[first : first + _SLICE]
            job = LoopInputs(reference=np.repeat(part, self.ticks, axis=0), parameters=numbers, gains=gains)
            result = self._kernel.run(state, len(part) * self.ticks, job, record_pose=False, record_states=True)
            if result.diverged >= 0 or result.states is None:
                raise UnstableCaseError(f"the closed loop of {self.nominal.name} ran away; draw the case anew")
            at = slice(None, None, self.ticks)
            found.append(np.hstack([result.command[at, m : 3 * m], result.states[at, : 2 * nq]]))
            state = result.final
        whole = np.concatenate(found)[lead:]
        return BlindRun(whole[:, :m], whole[:, m : 2 * m], whole[:, 2 * m :])

    def _start(self, inputs: BlindInputs, time: float) -> LoopState:

        m = self.robot.n_motors
        rest = self.robot.equilibrium(self.robot.home, motor_position=inputs.reference[0, :m])
        torque = self.robot.holding_torque(rest)
        x = np.concatenate([rest, self._plant.starts(), [time]])
        law = self.law.initial_state(self._context)
        line = np.tile(torque, self._loop.remembered + 1)
        memory = np.concatenate([[0.0], law, line, inputs.reference[0, :m]])
        wide = self._loop.width + (0 if self._correction is None else len(self._correction))
        return LoopState(x, memory, np.zeros((0, wide)))


def _robot_with_modes(robot: Robot, deviations: Sequence[Deviation]) -> tuple[Robot, int]:
    """Return the added bodies, and whether one of them precedes the first body of the robot."""
    first_body = 0
    for one in deviations:
        if one.effect == "extra_mode":
            robot = with_mode(robot, one.location, one.parameters)
            first_body += one.location == "base"
    return robot, first_body
