"""The closed loop of plant and controller as one kernel.

At every sampling instant t_k = k T:

    y_k = [sensor(encoder(x_k) + noise_k), further sensors(x_k) + noise_k],   z_k = tool pose of x_k
    u_k, c_k+1 = controller(c_k, r_k, y_k, g)
    x_k+1: fourth-order Runge-Kutta steps under the delayed command plus disturbance torque, and tool wrench,
           both held from t_k to t_k+1; the command of t_k acts from t_k + delay on.

    kernel = compile_loop(LoopFunctions(...), sample_time=5e-4)
    result = kernel.run(kernel.initial_state(x), n, LoopInputs(reference=r, gains=g))
    more = kernel.run(result.final, n, LoopInputs(reference=r2, gains=g))       # continues where it ended

    step = kernel.stepper(kernel.initial_state(x))                              # sample by sample, same bits
    step.measure(); step.command[:] = control(step.encoder); step.advance()
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from flexros.compile.command_delay import split_delays
from flexros.compile.loop.arrays import LoopInputs, LoopState, loop_result, make_job
from flexros.compile.loop.functions import loop_sizes
from flexros.compile.loop.machine_code import MachineCodeLoop
from flexros.compile.loop.virtual_machine import VirtualMachineLoop
from flexros.compile.machine_code import can_compile
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.compile.loop.arrays import LoopJob, LoopResult
    from flexros.compile.loop.functions import LoopFunctions, LoopSizes

_SLICE_WORK = 2_000_000  # states times lanes times samples between two looks at Ctrl-C


class LoopEngine(Protocol):
    """Seam between machine code and virtual machine: whole jobs, and the two halves of a sample on fixed arrays.

    All arrays have a last axis of lanes.
    """

    def run(self, job: LoopJob) -> int:
        """Run a job in place; return the number of samples until every lane has diverged, else all."""
        ...

    def measure(
        self, plant: FloatArray, noise: FloatArray, parameters: FloatArray, measured: FloatArray, tool_pose: FloatArray
    ) -> Callable[[], None]:
        """Prepare the measurement of all sensors and of the tool pose."""
        ...

    def advance(
        self,
        plant: FloatArray,
        line: FloatArray,
        command: FloatArray,
        disturbance: FloatArray,
        parameters: FloatArray,
    ) -> Callable[[], None]:
        """Prepare the step from one sample to the next."""
        ...


@dataclass(frozen=True)
class LoopKernel:
    """A closed loop ready to run; stateless and thread-safe.

    Attributes:
        sizes: Numbers of elements of all vectors.
        sample_time: T [s].
        line_length: Number of past commands that the delay remembers.
        lanes: Simulations side by side.
        engine: Implementation: machine code or virtual machine.
    """

    sizes: LoopSizes
    sample_time: float
    line_length: int
    lanes: int
    engine: LoopEngine

    def initial_state(self, plant: FloatArray, controller: FloatArray | None = None) -> LoopState:
        """Return an initial state with past commands of zero.

        Args:
            plant: Plant state x, shape (n_states,) or (n_states, lanes).
            controller: Controller state c, shape (n_controller_states,) or (..., lanes); zeros when None.
        """
        zeros = np.zeros(self.sizes.controller)
        line = np.zeros((self.line_length, self.sizes.motors))
        return LoopState(np.asarray(plant, dtype=np.float64), zeros if controller is None else controller, line)

    def run(
        self,
        state: LoopState,
        samples: int,
        inputs: LoopInputs,
        *,
        record_pose: bool = True,
        record_states: bool = False,
        progress: Callable[[int], None] | None = None,
    ) -> LoopResult:
        """Run the loop. It returns to Python now and then, so that Ctrl-C works.

        Args:
            state: Where to start; not changed.
            samples: Number of samples n.
            inputs: Reference, noise, disturbance, parameters, gains.
            record_pose: Compute and record the tool pose.
            record_states: Record the whole state.
            progress: Called with the number of samples done.

        Raises:
            InputError: An array has the wrong shape.
        """
        job = make_job(
            self.sizes, self.line_length, self.lanes, samples, state, inputs,
            record_pose=record_pose, record_states=record_states,
        )  # fmt: skip
        length = max(1, _SLICE_WORK // (self.sizes.state * self.lanes))
        for start in range(0, samples, length):
            part = job.part(start, min(start + length, samples))
            done = self.engine.run(part)
            fresh = (job.diverged < 0) & (part.diverged >= 0)
            job.diverged[fresh] = start + part.diverged[fresh]
            if progress is not None:
                progress(start + done)
            if (job.diverged >= 0).all():
                break
        return loop_result(job)

    def stepper(self, state: LoopState, parameters: FloatArray | None = None) -> LoopStepper:
        """Prepare the plant half of the loop for stepping sample by sample.

        Args:
            state: Where to start; not changed.
            parameters: Plant parameters p, shape (n_parameters,) or (n_parameters, lanes).

        Raises:
            InputError: An array has the wrong shape.
        """
        inputs = LoopInputs(parameters=parameters, gains=np.zeros(self.sizes.gains))
        job = make_job(
            self.sizes, self.line_length, self.lanes, 1, state, inputs, record_pose=True, record_states=False
        )  # fmt: skip
        return LoopStepper(self, job.plant, job.line, job.parameters)


class LoopStepper:
    """The plant of a loop, one sample at a time; bit-equal to the run over many samples.

    Write `noise`, `disturbance` and `command` in place, call `measure` then `advance`, read `encoder`, `further`,
    `tool_pose` and `plant`. All arrays have the shapes of one sample of the kernel: (width,), or (width, lanes).

    Attributes:
        plant: State x.
        noise: Noise of the encoders [rad], then of the further sensors, added by the next `measure`.
        disturbance: Motor torque [Nm] and tool wrench [N, Nm] during the next `advance`.
        command: Torque command of this sample [Nm].
        encoder: Motor positions of the last `measure` [rad].
        further: Values of the further sensors of the last `measure`.
        tool_pose: Position [m] and quaternion xyzw of the last `measure`.
        measure: Reads encoders and tool pose of the present state.
        advance: Moves the state one sample on.
    """

    def __init__(self, kernel: LoopKernel, plant: FloatArray, line: FloatArray, parameters: FloatArray) -> None:
        """Bind a kernel's halves to fresh arrays; see `LoopKernel.stepper`."""
        sizes, lanes = kernel.sizes, kernel.lanes
        noise, measured = (np.zeros((sizes.measured, lanes)) for _ in range(2))
        command = np.zeros((sizes.motors, lanes))
        disturbance = np.zeros((sizes.disturbance, lanes))
        tool_pose = np.zeros((sizes.pose, lanes))
        self.measure = kernel.engine.measure(plant, noise, parameters, measured, tool_pose)
        self.advance = kernel.engine.advance(plant, line, command, disturbance, parameters)

        def outside(array: FloatArray) -> FloatArray:
            return array[..., 0] if lanes == 1 else array

        self.plant, self.noise, self.disturbance = outside(plant), outside(noise), outside(disturbance)
        self.command, self.tool_pose = outside(command), outside(tool_pose)
        self.encoder, self.further = outside(measured[: sizes.motors]), outside(measured[sizes.motors :])
        self._line = outside(line)

    @property
    def line(self) -> FloatArray:
        """Past commands [Nm], newest first, shape (line_length, M) or (line_length, M, lanes)."""
        return self._line


def compile_loop(
    functions: LoopFunctions,
    *,
    sample_time: float,
    substeps: int = 1,
    delay: float | Sequence[float] = 0.0,
    lanes: int = 1,
    engine: Literal["auto", "machine_code", "virtual_machine"] = "auto",
) -> LoopKernel:
    """Build the kernel of a closed loop.

    Args:
        functions: Plant and controller.
        sample_time: Time T between two samples [s].
        substeps: Runge-Kutta steps per sample (per part of it where the delay splits it).
        delay: From the computing of a command to its acting [s], any value from zero on; of all motors, or of each.
        lanes: Simulations side by side: 1, 2, 4, 8, 16.
        engine: "machine_code", "virtual_machine", or "auto": machine code where llvmlite is installed.

    Raises:
        InputError: Functions do not fit together, or a number is out of range.
    """
    if substeps < 1:
        raise InputError(f"substeps = {substeps} is not possible: at least 1 integration step per sample is needed")
    sizes, timing = loop_sizes(functions), split_delays(delay, sample_time)
    compiled = engine == "machine_code" or (engine == "auto" and can_compile())
    make = MachineCodeLoop if compiled else VirtualMachineLoop
    return LoopKernel(sizes, sample_time, timing.line_length, lanes, make(functions, sizes, timing, substeps, lanes))
