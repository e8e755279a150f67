"""Frequency responses of a linearised robot and their exact Jacobian (Moberg 2007, Paper A, sections 3 and 5).

With A(jw) = -w^2 M + jw D + K, symmetric, and Z = A^-1 B the motor positions respond with G = B^T Z. A rank-one term
theta_p s_p (jw)^k b b^T of A gives

    dG/dtheta_p = -s_p (jw)^k v v^T,    v = Z^T b,

so the Jacobian needs no further solution. Any other parameter gives -Z^T (dA/dtheta_p) Z.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.sampled import SampledHold, expansion, sampled_hold

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.robot.linear.positions import LinearisedPositions


@dataclass(frozen=True, eq=False)
class FrequencyModel:
    """Sampled response of motor accelerations to torque commands at Q positions, in plain NumPy.

    Hold, delay and aliasing are those of the sampled loop (see `sampled`). The aliases are those of the parameters at
    which the positions were linearised: the Jacobian is exact, and the aliases are updated with each linearisation.

    Attributes:
        positions: Linear models of the positions.
        frequency: Frequencies [Hz], shape (F,), or (Q, F) where they differ from position to position.
        sample_time: T [s].
        delay: Time from the sampling instant to the change of the torque [s].
    """

    positions: LinearisedPositions
    frequency: FloatArray
    sample_time: float
    delay: float = 0.0

    def __post_init__(self) -> None:
        n_positions = len(self.positions.mass)
        if self.frequency.ndim not in (1, 2) or (self.frequency.ndim == 2 and len(self.frequency) != n_positions):
            raise InputError(
                f"frequencies have shape {self.frequency.shape}, but {n_positions} positions need one list for all or "
                f"{n_positions} lists of equal length; correct them"
            )

    @cached_property
    def hold(self) -> SampledHold:
        """Hold and sampling at the frequencies, arrays of leading shape (Q, F)."""
        shape = (len(self.positions.mass), self.frequency.shape[-1])
        hold = sampled_hold(self.frequency, self.sample_time, self.delay)
        orders = hold.aliases.shape[-1]
        return SampledHold(
            np.broadcast_to(hold.omega, shape),
            np.broadcast_to(hold.gain, shape),
            np.broadcast_to(hold.aliases, (*shape, orders)),
        )

    @cached_property
    def expansion(self) -> FloatArray:
        """Matrices of the expansion of G(s) in 1/s that the aliases consist of, shape (Q, 5, M, M)."""
        positions = self.positions
        return expansion(positions.mass, positions.damping, positions.stiffness, positions.motor_rows)

    def response(self, theta: FloatArray) -> ComplexArray:
        """Evaluate the frequency responses.

        Args:
            theta: Values of the parameters (SI), shape (P,).

        Returns:
            Torque command -> acceleration of the motors [1/(kg m2) or 1/kg], shape (Q, F, M, M).
        """
        return np.array([self._sampled(position, Z) for position, Z in enumerate(self._solutions(theta))])

    def jacobian(self, theta: FloatArray, scale: FloatArray | None = None) -> ComplexArray:
        """Evaluate the derivatives of the responses with respect to scaled parameters x.

        Args:
            theta: Values of the parameters (SI), shape (P,).
            scale: dtheta/dx, shape (P,); default: theta, so that x is the logarithm.

        Returns:
            Derivatives, units as `response`, shape (Q, F, M, M, P).
        """
        return self.response_and_jacobian(theta, scale)[1]

    def response_and_jacobian(
        self, theta: FloatArray, scale: FloatArray | None = None
    ) -> tuple[ComplexArray, ComplexArray]:
        """Evaluate both with one solution; see `response` and `jacobian`."""
        solutions = list(enumerate(self._solutions(theta)))
        responses = np.array([self._sampled(position, Z) for position, Z in solutions])
        per_step = theta if scale is None else scale
        return responses, np.array([self._slopes(position, Z, per_step) for position, Z in solutions])

    def _solutions(self, theta: FloatArray) -> Iterator[ComplexArray]:
        """Yield Z = A^-1 B of each position, shape (F, n, M)."""
        motors = self.positions.motor_rows
        drive = np.eye(self.positions.mass.shape[1])[:, motors]
        for omega, M, D, K in zip(self.hold.omega, *self.positions.matrices(theta), strict=True):
            w = omega[:, None, None]
            yield np.linalg.solve(K - w**2 * M + 1j * w * D, np.broadcast_to(drive, (len(omega), *drive.shape)))

    def _sampled(self, position: int, Z: ComplexArray) -> ComplexArray:
        """Sampled response of acceleration at one position, shape (F, M, M)."""
        direct = self.hold.gain[position][:, None, None] * Z[:, self.positions.motor_rows]
        sampled: ComplexArray = direct + np.tensordot(self.hold.aliases[position], self.expansion[position], 1)
        return sampled

    def _slopes(self, position: int, Z: ComplexArray, per_step: FloatArray) -> ComplexArray:
        """Derivatives of the response of one position, shape (F, M, M, P)."""
        positions, omega, gain = self.positions, self.hold.omega[position], self.hold.gain[position]
        powers = np.maximum(positions.powers, 0)
        v = np.einsum("pn,fnm->fmp", positions.vectors, Z)
        scale = -gain[:, None] * (1j * omega[:, None]) ** powers * (per_step * positions.factors[position])
        slopes: ComplexArray = v[:, :, None, :] * v[:, None, :, :] * scale[:, None, None, :]
        for slope, p in enumerate(positions.sloped):
            M, D, K = (
                part[position, slope]
                for part in (positions.mass_slopes, positions.damping_slopes, positions.stiffness_slopes)
            )
            w = omega[:, None, None]
            through = Z.swapaxes(1, 2) @ ((K - w**2 * M + 1j * w * D) @ Z)
            slopes[..., p] = -(gain * per_step[p])[:, None, None] * through
        return slopes
