"""Frequency response function of one position with its covariance, distortion levels and warnings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.quantity import derivative_order, differentiation, unit_of_quantity

if TYPE_CHECKING:
    import control
    import pandas as pd
    import plotly.graph_objects as go
    import xarray

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.frf.distortion import Distortion
    from flexros.identify.frf.quantity import Quantity

CovarianceKind = Literal["total", "noise"]
"""total: from blocks, with nonlinear distortion; noise: from periods, with noise alone."""


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse:
    """Non-parametric model G(jw) of one position, from n_u torque commands to n_y motors.

    DFTs are scaled to amplitudes, X = 2/N sum x(t) exp(-j w t): (4.3) of Moberg (2007) times 2/sqrt(N), which cancels
    in G. The output error of one experiment (mean over its periods) is E = Y - G U with covariance C_E; an estimate
    is G = Y W with U W = I over all m experiments, so that G - G_0 = E W, and with vec stacking columns

        cov(vec G) = conj(W^H W) kron C_E .

    Attributes:
        frequency: Excited lines [Hz], increasing, shape (F,).
        response: Torque command -> motor `quantity`, shape (F, n_y, n_u).
        noise_error: Covariance of the output error of one experiment due to noise, from the variation over periods
            [(unit of output)^2], shape (F, n_y, n_y); None with one period.
        total_error: The same with stochastic nonlinear distortion, from the variation over blocks; None with one block.
        input_inverse: W^H W summed over all experiments and blocks, (U U^H)^-1 for the least-squares estimate
            [(unit of input)^-2], shape (F, n_u, n_u).
        degrees_of_freedom: Complex degrees of freedom of each total_error (noise_error where that is None); the
            covariance is pooled over neighbouring lines, and lines shared by two errors are counted once.
        input_names: Names of the inputs, length n_u.
        output_names: Names of the outputs, length n_y.
        input_units: Units of the inputs, "Nm" or "N", length n_u.
        coordinate_units: Units of the positions of the outputs, "rad" or "m", length n_y.
        gears: Gear angles of the position [rad or m], shape (M,).
        motor_position: Mean measured motor position [rad or m], shape (M,); NaN where positions were not measured.
        sample_time: T_s [s].
        n_periods: Recorded whole periods per experiment.
        n_blocks: Blocks of experiments.
        quantity: Quantity of the outputs.
        distortion: Levels of noise, odd and even distortion and time variation; None where unknown.
        warnings: Findings in the record, one sentence each.
    """

    frequency: FloatArray
    response: ComplexArray
    noise_error: ComplexArray | None
    total_error: ComplexArray | None
    input_inverse: ComplexArray
    degrees_of_freedom: float
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    input_units: tuple[str, ...]
    coordinate_units: tuple[str, ...]
    gears: FloatArray
    motor_position: FloatArray
    sample_time: float
    n_periods: int
    n_blocks: int
    quantity: Quantity = "acceleration"
    distortion: Distortion | None = None
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n_f, n_y, n_u = len(self.frequency), len(self.output_names), len(self.input_names)
        shapes: dict[str, tuple[int, ...]] = {
            "frequency": (n_f,),
            "response": (n_f, n_y, n_u),
            "noise_error": (n_f, n_y, n_y),
            "total_error": (n_f, n_y, n_y),
            "input_inverse": (n_f, n_u, n_u),
        }
        for name, shape in shapes.items():
            array = getattr(self, name)
            if array is not None and array.shape != shape:
                raise InputError(
                    f"FrequencyResponse.{name} has shape {array.shape}, allowed is {shape}; "
                    "give one entry per frequency"
                )
        derivative_order(self.quantity)

    @property
    def output_units(self) -> tuple[str, ...]:
        """Units of the outputs, e.g. "rad/s²", length n_y."""
        return tuple(unit_of_quantity(unit, self.quantity) for unit in self.coordinate_units)

    def as_quantity(self, quantity: Quantity) -> FrequencyResponse:
        """Return the same response with another quantity as output, multiplied by (j w)^k exactly.

        Args:
            quantity: position, velocity or acceleration.

        Raises:
            InputError: The quantity is not known, or a response at 0 Hz would have to be integrated.
        """
        order = derivative_order(quantity) - derivative_order(self.quantity)
        if order < 0 and np.any(self.frequency == 0):
            raise InputError(f"the {self.quantity} at 0 Hz cannot be integrated to {quantity}; leave the line 0 Hz out")
        factor = differentiation(self.frequency, order)[:, None, None]
        noise, total = (
            None if error is None else error * abs(factor) ** 2 for error in (self.noise_error, self.total_error)
        )
        distortion = None if self.distortion is None else self.distortion.differentiated(order)
        return replace(
            self,
            response=self.response * factor,
            noise_error=noise,
            total_error=total,
            quantity=quantity,
            distortion=distortion,
        )

    def error(self, kind: CovarianceKind = "total") -> ComplexArray:
        """Return the covariance of the output error of one experiment.

        Args:
            kind: total or noise.

        Returns:
            C_E [(unit of output)^2], shape (F, n_y, n_y).

        Raises:
            InputError: The record has too few blocks (total) or periods (noise).
        """
        error = {"total": self.total_error, "noise": self.noise_error}[kind]
        if error is None:
            few = "blocks" if kind == "total" else "periods"
            raise InputError(f"the {kind} covariance of this frequency response is not known; record two {few} or more")
        return error

    def covariance(self, kind: CovarianceKind = "total") -> ComplexArray:
        """Return the covariance of the estimate, E[vec(G - G_0) vec(G - G_0)^H]; vec stacks columns.

        Args:
            kind: total or noise.

        Returns:
            Covariance [(unit of response)^2], shape (F, n_y n_u, n_y n_u).
        """
        error, inverse = self.error(kind), np.conj(self.input_inverse)
        product = np.einsum("fab,fij->faibj", inverse, error)
        n = product.shape[1] * product.shape[2]
        return np.asarray(product.reshape(len(product), n, n))

    def standard_deviation(self, kind: CovarianceKind = "total") -> FloatArray:
        """Return the standard deviation of |G - G_0|, sqrt(E|G - G_0|^2).

        Args:
            kind: total or noise.

        Returns:
            Standard deviation [unit of response], shape (F, n_y, n_u).
        """
        output = np.einsum("fii->fi", self.error(kind)).real
        inverse = np.einsum("faa->fa", self.input_inverse).real
        return np.asarray(np.sqrt(output[:, :, None] * inverse[:, None, :]))

    def frd(self) -> control.FrequencyResponseData:
        """Return the response as python-control FrequencyResponseData over w [rad/s]."""
        import control  # deferred: slow to import

        response = np.moveaxis(self.response, 0, 2)
        names = {"inputs": list(self.input_names), "outputs": list(self.output_names)}
        return control.FrequencyResponseData(response, 2 * np.pi * self.frequency, self.sample_time, **names)

    def to_control(self) -> control.FrequencyResponseData:
        """Return the response for python-control, see `frd`."""
        return self.frd()

    def to_xarray(self) -> xarray.Dataset:
        """Return response, covariances, standard deviations and distortion levels as labelled arrays."""
        from flexros.identify.frf.files.labelled import dataset_of

        return dataset_of(self)

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each line [Hz], output and input: complex response, magnitude, phase [deg], deviation.

        `std` is the standard deviation in the unit of the magnitude, NaN where the record does not determine it.
        """
        from flexros.identify.frf.files.labelled import frame_of

        return frame_of(self)

    def plot(self) -> go.Figure:
        """Draw magnitude or phase of each pair of input and output, with its standard deviation."""
        from flexros.identify.frf.response_picture import response_picture

        return response_picture((self,))

    def __repr__(self) -> str:
        shape = f"{len(self.output_names)} x {len(self.input_names)}"
        band = f"{self.frequency[0]:.4g} to {self.frequency[-1]:.4g} Hz"
        return f"<FrequencyResponse {shape}, {len(self.frequency)} lines from {band}, {self.quantity} over torque>"
