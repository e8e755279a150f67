"""The functions that make up a closed loop, and their sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    import casadi as ca

WRENCH_SIZE = 6
N_WEIGHTS = 3
"""Number of weights of a step, see `step_weights`."""


@dataclass(frozen=True)
class LoopFunctions:
    """Plant and controller as CasADi functions.

    An effect with continuous states of its own (actuator lag, filters, time) appends them to the state x, and their
    equations to `derivative`. The optional functions are stages that an explicit integrator cannot represent.

    Attributes:
        derivative: (x, u, w, p) -> dx/dt; u (M,) motor torque [Nm], w (6,) wrench at the tool [N, Nm].
        encoder: (leading part of x) -> (M,) motor positions [rad].
        tool_pose: (leading part of x, p) -> (7,) position [m] and quaternion xyzw.
        controller: (c, r, y, g) -> (u, c_next), where y are the encoder values, then those of the further sensors.
        sensor: (y, x, p) -> y, acting on the noisy encoder values: quantisation, periodic errors. None: no change.
        further: (x, p) -> (n_further,) values of sensors beside the encoders. None: there are none.
        exact_update: (x, u, w, p, h) -> x after time h [s] by the dynamics that `derivative` omits, solved exactly:
            stiff bristles, stick and slip. Applied for h/2 before and after every step (Strang 1968,
            second order). None: nothing is omitted.
        before_step: (x, u, w, p, h) -> x, called once before every step of length h [s]: sets quantities
            held during the step, such as a mean friction torque. None: nothing.
        after_step: The same after every step: updates states that depend on its end point, such as the slip of an
            element of a hysteresis. None: nothing.
        step: (x, u, w, p, weights) -> x one step later, with the weights of `step_weights`. None: the Runge-Kutta step
            of `derivative`.
    """

    derivative: ca.Function
    encoder: ca.Function
    tool_pose: ca.Function
    controller: ca.Function
    sensor: ca.Function | None = None
    further: ca.Function | None = None
    exact_update: ca.Function | None = None
    before_step: ca.Function | None = None
    after_step: ca.Function | None = None
    step: ca.Function | None = None


@dataclass(frozen=True)
class LoopSizes:
    """Number of elements of every vector of the loop.

    Attributes:
        state: Plant state x.
        motors: Motors M, also encoder values and commands.
        controller: Controller state c.
        reference: Reference r.
        gains: Controller parameters g.
        parameters: Plant parameters p.
        pose: Tool pose.
        further: Values of sensors beside the encoders.
    """

    state: int
    motors: int
    controller: int
    reference: int
    gains: int
    parameters: int
    pose: int
    further: int = 0

    @property
    def measured(self) -> int:
        """Measurement y: encoder values, then those of the further sensors."""
        return self.motors + self.further

    @property
    def disturbance(self) -> int:
        """Disturbance d: motor torque (M) [Nm] and tool wrench (6) [N, Nm]."""
        return self.motors + WRENCH_SIZE


def loop_sizes(functions: LoopFunctions) -> LoopSizes:
    """Read the sizes off the functions and check that they fit together.

    Raises:
        InputError: Naming the function and the argument that do not fit.
    """
    derivative, controller = functions.derivative, functions.controller
    _check_counts("derivative", derivative, 4, 1)
    _check_counts("controller", controller, 4, 2)
    sizes = LoopSizes(
        state=derivative.numel_in(0),
        motors=derivative.numel_in(1),
        controller=controller.numel_in(0),
        reference=controller.numel_in(1),
        gains=controller.numel_in(3),
        parameters=derivative.numel_in(3),
        pose=functions.tool_pose.numel_out(0),
        further=0 if functions.further is None else functions.further.numel_out(0),
    )
    x, m, p = sizes.state, sizes.motors, sizes.parameters
    _check_sizes("derivative", derivative, (x, m, WRENCH_SIZE, p), (x,))
    _check_sizes(
        "controller",
        controller,
        (sizes.controller, sizes.reference, sizes.measured, sizes.gains),
        (m, sizes.controller),
    )
    _check_counts("encoder", functions.encoder, 1, 1)
    _check_sizes("encoder", functions.encoder, (min(x, functions.encoder.numel_in(0)),), (m,))
    _check_counts("tool_pose", functions.tool_pose, 2, 1)
    _check_sizes("tool_pose", functions.tool_pose, (min(x, functions.tool_pose.numel_in(0)), p), (sizes.pose,))
    if functions.sensor is not None:
        _check_counts("sensor", functions.sensor, 3, 1)
        _check_sizes("sensor", functions.sensor, (m, x, p), (m,))
    if functions.further is not None:
        _check_counts("further", functions.further, 2, 1)
        _check_sizes("further", functions.further, (x, p), (sizes.further,))
    for name, last in (("exact_update", 1), ("before_step", 1), ("after_step", 1), ("step", N_WEIGHTS)):
        update: ca.Function | None = getattr(functions, name)
        if update is not None:
            _check_counts(name, update, 5, 1)
            _check_sizes(name, update, (x, m, WRENCH_SIZE, p, last), (x,))
    return sizes


def _check_counts(name: str, function: ca.Function, n_in: int, n_out: int) -> None:
    if (function.n_in(), function.n_out()) != (n_in, n_out):
        raise InputError(
            f"loop function '{name}' has {function.n_in()} inputs and {function.n_out()} outputs: "
            f"it must have {n_in} and {n_out}, see LoopFunctions"
        )


def _check_sizes(name: str, function: ca.Function, inputs: tuple[int, ...], outputs: tuple[int, ...]) -> None:
    found_in = tuple(function.numel_in(k) for k in range(len(inputs)))
    found_out = tuple(function.numel_out(k) for k in range(len(outputs)))
    if found_in != inputs or found_out != outputs:
        raise InputError(
            f"loop function '{name}' maps sizes {found_in} to {found_out}: "
            f"the other functions of the loop need {inputs} to {outputs}"
        )
