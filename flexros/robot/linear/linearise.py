"""Linear model of a robot at rest in a pose, as second-order matrices and as a python-control object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.parameters import SERVO
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    import control
    import pandas as pd
    import plotly.graph_objects as go
    from numpy.typing import ArrayLike

    from flexros.arrays import FloatArray
    from flexros.robot.robot import Robot


@dataclass(frozen=True)
class LinearModel:
    """M dq'' + D dq' + K dq = B du about an equilibrium, with motor positions and an output as measurements.

    Attributes:
        mass: M, shape (n, n) with n coordinates q = [q_a, q_m].
        damping: D, shape (n, n).
        stiffness: K, gravity load included, shape (n, n).
        input: B, shape (n, M).
        encoder: Motor positions = encoder @ dq, shape (M, n).
        output: Controlled output = output @ dq, shape (n_out, n).
        input_names: motor_1, ..., length M.
        output_names: Names of the components of the controlled output, length n_out.
        input_units: Units of the motor torques, "Nm" or for a linear motor "N", length M.
        measurement_units: Units of motor positions and components of the output, "rad" or "m", length M + n_out.
        state: The equilibrium, shape (2 n,).
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    input: FloatArray
    encoder: FloatArray
    output: FloatArray
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    input_units: tuple[str, ...]
    measurement_units: tuple[str, ...]
    state: FloatArray

    @property
    def measurement_names(self) -> tuple[str, ...]:
        """Names of all measurements: motor positions, then the components of the output."""
        return self.input_names + self.output_names

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return A, B, C, D of the first-order form with state [dq, dq'] and all measurements."""
        n = len(self.mass)
        inverse = np.linalg.inv(self.mass)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ self.stiffness, -inverse @ self.damping]])
        B = np.vstack([np.zeros_like(self.input), inverse @ self.input])
        C = np.vstack([self.encoder, self.output])
        C = np.hstack([C, np.zeros_like(C)])
        return A, B, C, np.zeros((len(C), B.shape[1]))

    def state_space(self) -> control.StateSpace:
        """Return the model as a python-control StateSpace from motor torques to motor positions and output."""
        import control  # here, because it loads slowly

        n = len(self.mass)
        states = [f"q{i + 1}" for i in range(n)] + [f"v{i + 1}" for i in range(n)]
        outputs = [name.replace(".", "_") for name in self.measurement_names]  # dots are not allowed there
        return control.ss(*self.matrices(), inputs=list(self.input_names), outputs=outputs, states=states)

    def to_control(self) -> control.StateSpace:
        """Return the model for python-control, see `state_space`."""
        return self.state_space()

    def to_pandas(self) -> pd.DataFrame:
        """Return the modes: natural frequency [Hz] and damping ratio [1], by frequency."""
        from flexros.robot.shown import modes_frame

        return modes_frame(self)

    def plot(self, low: float = 0.5, high: float = 200.0) -> go.Figure:
        """Draw magnitude and phase from every motor torque to every measurement, in acceleration units.

        Args:
            low: Lowest frequency [Hz].
            high: Highest frequency [Hz].
        """
        from flexros.robot.linear.bode import bode_figure

        return bode_figure(self, low=low, high=high)

    def _repr_html_(self) -> str:
        from flexros.robot.shown import linear_html

        return linear_html(self)


def linear_model(robot: Robot, q_a: ArrayLike | None = None, output: str | None = None) -> LinearModel:
    """Linearise a robot at rest (Moberg 2007, Paper B, section 3.2).

    The servos of a robot that is commanded by positions are closed, below their torque limits and without integral
    parts; the inputs are torques at the motors all the same.

    Args:
        robot: The robot.
        q_a: Arm coordinates [rad or m], shape (N,); default: the home pose.
        output: Name of the controlled output; default: that of the robot file.

    Returns:
        The linear model.

    Raises:
        InputError: Invalid pose, unknown output, or no equilibrium.
    """
    state = robot.equilibrium(robot.home if q_a is None else q_a)
    n = robot.n_coordinates
    evaluate = robot.model.linearised(output)
    values = evaluate(state[:n], state[n:], robot.holding_torque(state))
    mass, damping, stiffness, torque, encoder, slope = (np.asarray(value, dtype=float) for value in values)
    if robot.commands == "position":
        gains = {
            name: np.diag([robot.parameters[f"{motor}.{SERVO}{name}"].value for motor in robot.joint_names])
            for name in ("stiffness", "damping")
        }
        stiffness = stiffness + torque @ gains["stiffness"] @ encoder
        damping = damping + torque @ gains["damping"] @ encoder
    return LinearModel(
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        input=torque,
        encoder=encoder,
        output=slope,
        input_names=robot.joint_names,
        output_names=_component_names(robot, output),
        input_units=tuple(motor.torque_unit for motor in robot.motors),
        measurement_units=(
            *(motor.position_unit for motor in robot.motors),
            *(unit_of("position", rotary) for rotary in _rotary_components(robot, output)),
        ),
        state=state,
    )


def _component_names(robot: Robot, output: str | None) -> tuple[str, ...]:
    entry = robot.spec.outputs[output or robot.controlled]
    return entry.coordinates or tuple(entry.pose)


def _rotary_components(robot: Robot, output: str | None) -> tuple[bool, ...]:
    """Return whether each component of an output is an angle: pose component rx or arm coordinate body_1.rx."""
    return tuple(name.rsplit(".", 1)[-1].startswith("r") for name in _component_names(robot, output))
