"""What prediction errors look like without any gap: their spectrum, up to its level."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.prediction.observer import ObserverGain

GRID = 512
"""Frequencies from zero to the Nyquist frequency at which a spectrum is stored (chosen)."""


@dataclass(frozen=True, eq=False)
class ErrorDynamics:
    """How noise and missing torques pass into the prediction errors of a predictor with a fixed gain.

    Attributes:
        transition: F (I - K C), shape (n_x, n_x).
        injection: F K, shape (n_x, M).
        measurement: C, shape (M, n_x).
    """

    transition: FloatArray
    injection: FloatArray
    measurement: FloatArray

    def response(self, z: ComplexArray, entry: FloatArray) -> ComplexArray:
        """Evaluate C (zI - F(I - KC))^-1 B.

        Args:
            z: Points on the unit circle, shape (F,).
            entry: B, how the input enters the state, shape (n_x, k).

        Returns:
            Response, shape (F, M, k).
        """
        values, vectors = np.linalg.eig(self.transition)
        left = self.measurement @ vectors
        right = np.linalg.solve(vectors, entry.astype(complex))
        modal = 1 / (z[:, None] - values)
        return np.asarray(np.einsum("ai,fi,ib->fab", left, modal, right, optimize=True))


def error_dynamics(observer: ObserverGain) -> ErrorDynamics:
    """Put together the error dynamics of a predictor.

    Args:
        observer: Its gain.

    Returns:
        The dynamics.
    """
    return ErrorDynamics(observer.transition, observer.motion @ observer.gain, observer.readout)


def white(n_motors: int) -> FloatArray:
    """Return the spectrum of prediction errors that are white without a gap, shape (`GRID`, M)."""
    return np.ones((GRID, n_motors))


def of_predictor(observer: ObserverGain) -> FloatArray:
    """Compute the spectrum of prediction errors that come from the noise of the encoders alone.

    Args:
        observer: Gain of the predictor, with the noise that it was made for.

    Returns:
        Power density from zero to the Nyquist frequency, of mean one, shape (`GRID`, M).
    """
    dynamics = error_dynamics(observer)
    z = np.exp(1j * np.pi * (np.arange(GRID) + 0.5) / GRID)
    H = np.eye(len(observer.noise)) - dynamics.response(z, dynamics.injection)
    power = np.einsum("fij,j->fi", np.abs(H) ** 2, np.maximum(observer.noise, 1e-12) ** 2)
    return np.asarray(power / power.mean(axis=0))


def autoregressive(coefficients: FloatArray) -> FloatArray:
    """Compute the spectrum of an autoregressive process e_k = a_1 e_k-1 + ... + a_p e_k-p + white noise.

    Args:
        coefficients: a_1 ... a_p of each motor, shape (p, M).

    Returns:
        Power density from zero to the Nyquist frequency, of mean one, shape (`GRID`, M).
    """
    angle = np.pi * (np.arange(GRID) + 0.5) / GRID
    delays = np.exp(-1j * angle[:, None] * (1 + np.arange(len(coefficients))))
    power = 1 / np.abs(1 - delays @ coefficients) ** 2
    return np.asarray(power / power.mean(axis=0))
