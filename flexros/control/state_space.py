"""Linear controller in discrete state space, with torque limit and anti-windup."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import casadi as ca
import numpy as np
from pydantic import Field, field_validator, model_validator

from flexros.config.per_motor import PositivePerMotor, per_motor
from flexros.control.base import AbstractControlLaw
from flexros.control.design.anti_windup import anti_windup_gain
from flexros.control.design.matrix_file import read_matrices
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext
    from flexros.robot import Robot

Matrix: TypeAlias = tuple[tuple[float, ...], ...]
"""Rows of a matrix."""

ERROR, REFERENCE = "_error", "_reference"
"""Endings of the names of inputs: reference less measurement, and the reference itself."""

_SAME_TIME = 1e-9
"""Relative difference up to which two sample times are the same [1]."""


class StateSpace(AbstractControlLaw):
    """Any linear controller, given by its discrete matrices.

    With the inputs e_k in the order of `inputs`, the limit of the torque and the feedforward torque:

        v_k     = C x_k + D e_k                                     wanted feedback torque
        u_k     = limit(feedforward_k + v_k)
        a_k     = u_k - limit(feedforward_k)                        feedback torque that acts
        x_{k+1} = A x_k + B e_k + L (a_k - v_k)

    The last term acts in the limit only: the controller observes the torque that acts (Astrom and Wittenmark (1997),
    Computer-Controlled Systems, section 9.4; Hanus et al. (1987) where L = B D^-1). A feedforward that alone reaches
    the limit leaves the state alone. By default L is the Kalman gain of the controller with white inputs. The state
    starts at zero.
    """

    kind: ClassVar[str] = "state_space"

    A: Matrix = Field(description="system matrix, rows of n numbers; n = 0, [], for a gain D alone [1]")
    B: Matrix = Field(description="input matrix, n rows, one column per input [1 per unit of the input]")
    C: Matrix = Field(description="output matrix [Nm, or N], one row per motor, n columns")
    D: Matrix = Field(description="direct gain [Nm or N per unit of the input], a row per motor, a column per input")
    inputs: tuple[str, ...] = Field(
        default=("motor_position_error",),
        min_length=1,
        description="signals that enter [name], in order, each with all its elements: a measurement such as "
        "motor_position, or its name with _error for reference less measurement or with _reference for the reference",
    )
    anti_windup: Matrix | None = Field(
        default=None,
        description="gain L of the torque lost in the limit [1/Nm or 1/N], n rows, one column per motor; "
        "default: Kalman gain of the controller with white inputs",
    )
    matrices_sample_time: float | None = Field(
        default=None, gt=0.0, description="sample time of the matrices [s], compared with that of the loop"
    )
    torque_limit: PositivePerMotor | None = Field(
        default=None, description="limit of the command [Nm], one or one per motor; default: the limits of the robot"
    )
    file: str = Field(
        default="",
        description="file [path] that holds A, B, C, D instead, and anti_windup and sample_time if needed: .npz, .mat, "
        ".json or .yaml; relative to the current folder, in a controller file of the benchmark to that file",
    )

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, given: Any) -> Any:
        """Read the matrices of a file; the law keeps them, so that a record of the run is complete."""
        if not isinstance(given, dict) or not given.get("file"):
            return given
        twice = sorted({"A", "B", "C", "D"} & set(given))
        if twice:
            raise ValueError(f"gives {', '.join(twice)} as well as file, allowed is one of them; remove the other")
        try:
            return {**given, **read_matrices(str(given["file"])), "file": ""}
        except InputError as error:
            raise ValueError(str(error)) from error

    @field_validator("A", "B", "C", "D", "anti_windup", mode="before")
    @classmethod
    def _as_rows(cls, given: Any) -> Any:
        """Accept arrays."""
        return np.asarray(given, dtype=float).tolist() if isinstance(given, np.ndarray) else given

    @model_validator(mode="after")
    def _sizes_fit(self) -> StateSpace:
        n = len(self.A)
        columns = len(self.D[0]) if self.D else 0
        motors = len(self.D)
        wanted = {"A": (n, n), "B": (n, columns), "C": (motors, n), "D": (motors, columns)}
        if self.anti_windup is not None:
            wanted["anti_windup"] = (n, motors)
        if not motors or not columns:
            raise ValueError("D is empty, but needs one row per motor and one column per input; add it")
        for name, (rows, width) in wanted.items():
            matrix: Matrix = getattr(self, name)
            if len(matrix) != rows or any(len(row) != width for row in matrix):
                given = f"{len(matrix)} rows of {sorted({len(row) for row in matrix})} numbers"
                raise ValueError(f"{name} has {given}, needed are {rows} rows of {width} (from A and D); correct it")
        return self

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states, n."""
        return len(self.A) * self._copies(context)

    def gain_names(self, context: LoopContext) -> tuple[str, ...]:
        """Return the names of all entries by rows, e.g. "A.1.2", of A, B, C, D and L, then "motor_1.torque_limit"."""
        entries = [
            f"{name}.{row + 1}.{column + 1}"
            for name, (rows, width) in zip("ABCDL", self._shapes(context), strict=True)
            for row in range(rows)
            for column in range(width)
        ]
        return (*entries, *(f"motor_{motor}.torque_limit" for motor in range(1, context.n_motors + 1)))

    def gains(self, context: LoopContext) -> FloatArray:
        """Return all entries of A, B, C, D and L, then the torque limits, shape (n_gains,)."""
        return np.concatenate(
            [*(matrix.ravel() for matrix in self.matrices(context)), self.command_limits(context.robot)]
        )

    def matrices(self, context: LoopContext) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return A, B, C, D and the anti-windup gain L as arrays, of all motors.

        Raises:
            InputError: The matrices do not fit the loop.
        """
        self._check(context)
        n, motors, columns = len(self.A), len(self.D), len(self.D[0])
        A, B = np.reshape(self.A, (n, n)).astype(float), np.reshape(self.B, (n, columns)).astype(float)
        C, D = np.reshape(self.C, (motors, n)).astype(float), np.reshape(self.D, (motors, columns)).astype(float)
        given = self.anti_windup
        L = anti_windup_gain(A, B, C, D) if given is None else np.reshape(given, (n, motors)).astype(float)
        copies = self._copies(context)
        if copies == 1:
            return A, B, C, D, L
        each = np.eye(copies)
        entry, direct = np.zeros((copies * n, copies * columns)), np.zeros((copies, copies * columns))
        for motor in range(copies):  # the inputs are stacked signal by signal, each with all motors
            entry[motor * n : (motor + 1) * n, motor::copies] = B
            direct[motor, motor::copies] = D
        return np.kron(each, A), entry, np.kron(each, C), direct, np.kron(each, L)

    def _shapes(self, context: LoopContext) -> tuple[tuple[int, int], ...]:
        """Return the shapes of A, B, C, D and L of all motors."""
        n, copies = self.state_size(context), self._copies(context)
        columns, motors = copies * len(self.D[0]), context.n_motors
        return (n, n), (n, columns), (motors, n), (motors, columns), (n, motors)

    def _copies(self, context: LoopContext) -> int:
        """Return the number of motors that get a controller of their own, 1 for one controller of all."""
        per_motor = all(size == context.n_motors for size in self._input_sizes(context))
        one = (len(self.D), len(self.D[0])) == (1, len(self.inputs))
        return context.n_motors if per_motor and one else 1

    def command_limits(self, robot: Robot) -> FloatArray:
        """Return the lower of the controller's and the robot's torque limit [Nm or N], shape (M,)."""
        if self.torque_limit is None:
            return robot.torque_limits
        return np.minimum(robot.torque_limits, per_motor("controller.torque_limit", self.torque_limit, robot.n_motors))

    def function(self, context: LoopContext) -> ca.Function:
        """Build the update `(c, r, y, g) -> (u, c_next)` as a CasADi SX function; all matrices are gains."""
        self._check(context)
        shapes = self._shapes(context)
        state, gains = ca.SX.sym("c", shapes[0][0]), ca.SX.sym("g", len(self.gain_names(context)))
        reference = ca.SX.sym("r", context.references.size)
        measured = ca.SX.sym("y", context.measurements.size)
        parts, taken = [], 0
        for rows, width in shapes:
            parts.append(ca.reshape(gains[taken : taken + rows * width], width, rows).T)
            taken += rows * width
        A, B, C, D, L = parts
        limit = gains[taken:]
        entering = ca.vertcat(*(self._input(name, reference, measured, context) for name in self.inputs))
        feedforward = context.references.part(reference, "feedforward_torque")
        wanted = C @ state + D @ entering
        command = _limited(feedforward + wanted, limit)
        acting = command - _limited(feedforward, limit)
        lost = ca.if_else(ca.fabs(feedforward + wanted) > limit, acting - wanted, 0.0)
        after = A @ state + B @ entering + L @ lost
        return ca.Function(
            self.kind,
            [state, reference, measured, gains],
            [command, ca.densify(after)],
            ["c", "r", "y", "g"],
            ["u", "c_next"],
        )

    @staticmethod
    def _input(name: str, reference: ca.SX, measured: ca.SX, context: LoopContext) -> ca.SX:
        """Return one input of the controller."""
        if name.endswith(ERROR):
            signal = name.removesuffix(ERROR)
            return context.references.part(reference, signal) - context.measurements.part(measured, signal)
        if name.endswith(REFERENCE):
            return context.references.part(reference, name.removesuffix(REFERENCE))
        return context.measurements.part(measured, name)

    def _check(self, context: LoopContext) -> None:
        """Check that the matrices fit the loop.

        Raises:
            InputError: Unknown input, wrong numbers of inputs or motors, or another sample time.
        """
        width = sum(self._input_sizes(context))
        if self._copies(context) == 1 and (len(self.D), len(self.D[0])) != (context.n_motors, width):
            raise InputError(
                f"controller.D has {len(self.D)} rows of {len(self.D[0])} numbers, but robot {context.robot.name} has "
                f"{context.n_motors} motors and the inputs {', '.join(self.inputs)} have {width} elements; correct it"
            )
        given = self.matrices_sample_time
        if given is not None and abs(given - context.sample_time) > _SAME_TIME * context.sample_time:
            raise InputError(
                f"controller.matrices_sample_time is {given:g} s, but the loop has {context.sample_time:g} s; give "
                "matrices for the sample time of the loop"
            )

    def _input_sizes(self, context: LoopContext) -> list[int]:
        """Return the number of elements of each input.

        Raises:
            InputError: Unknown input.
        """
        measurements, references = context.measurements.sizes, context.references.sizes
        allowed = {
            **measurements,
            **{f"{name}{ERROR}": size for name, size in measurements.items() if name in references},
            **{f"{name}{REFERENCE}": size for name, size in references.items()},
        }
        for name in self.inputs:
            if name not in allowed:
                raise unknown_name("input", name, allowed, "controller.inputs")
        return [allowed[name] for name in self.inputs]


def _limited(torque: ca.SX, limit: ca.SX) -> ca.SX:
    return ca.fmax(-limit, ca.fmin(limit, torque))
