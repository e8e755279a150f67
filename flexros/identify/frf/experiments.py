"""Samples of experiments at one position, as arrays: the input of every estimator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.frequency_response import FrequencyResponse

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.distortion import Distortion
    from flexros.identify.frf.quantity import Quantity


@dataclass(frozen=True, eq=False)
class Experiments:
    """m experiments of P records each at one position.

    Attributes:
        inputs: Torque commands [Nm or N], shape (m, P N, n_u).
        outputs: Motor positions (or another quantity) [rad or m], shape (m, P N, n_y).
        reference: Reference of the controller [any unit], shape (m, P N, n_r); None where it is not known.
        n_periods: Number P of whole periods, or of records from rest to rest.
        sample_time: T_s [s].
        periodic: Whether the records are whole periods in steady state.
        excited: Excited lines, multiples of one over a record, shape (F,).
        odd_detection: Odd lines left empty, shape (D,).
        even_detection: Even lines left empty, shape (E,).
        block: Block of each experiment, shape (m,).
        input_names: Length n_u.
        output_names: Length n_y.
        input_units: "Nm" or "N", length n_u.
        coordinate_units: "rad" or "m", length n_y.
        quantity: Quantity of the outputs.
        gears: Gear angles of the position [rad or m], shape (M,).
        label: Name in errors and warnings, e.g. "position 3".
    """

    inputs: FloatArray
    outputs: FloatArray
    reference: FloatArray | None
    n_periods: int
    sample_time: float
    periodic: bool
    excited: IntArray
    odd_detection: IntArray
    even_detection: IntArray
    block: IntArray
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    input_units: tuple[str, ...]
    coordinate_units: tuple[str, ...]
    quantity: Quantity
    gears: FloatArray
    label: str

    @classmethod
    def of(
        cls,
        inputs: ArrayLike,
        outputs: ArrayLike,
        sample_time: float,
        *,
        reference: ArrayLike | None = None,
        n_periods: int = 1,
        periodic: bool = True,
        lines: ArrayLike | None = None,
        band: tuple[float, float] | None = None,
        block: ArrayLike | None = None,
        quantity: Quantity = "position",
        label: str = "the record",
    ) -> Experiments:
        """Create experiments from plain arrays, of one input and output or of several.

        Args:
            inputs: Shape (m, n, n_u); (m, n) or (n,) for one input.
            outputs: Shape (m, n, n_y); (m, n) or (n,) for one output.
            sample_time: T_s [s].
            reference: Reference, shapes as for the inputs; None where it is not known.
            n_periods: Number of whole periods or records of equal length in the n samples.
            periodic: Whether these are whole periods in steady state.
            lines: Excited lines, multiples of one over the period; default: all within the band.
            band: Lowest and highest frequency [Hz]; default: from line 1 to just below the Nyquist frequency.
            block: Block of each experiment, shape (m,); default: as many experiments in each block as inputs.
            quantity: Quantity of the outputs.
            label: Name of the record in errors.

        Raises:
            InputError: Shapes do not match, or no line is within the band.
        """
        u, y = _stack(inputs, "inputs"), _stack(outputs, "outputs")
        r = None if reference is None else _stack(reference, "reference")
        for name, array in (("outputs", y), ("reference", r)):
            if array is not None and array.shape[:2] != u.shape[:2]:
                raise InputError(
                    f"{name} have {array.shape[0]} experiments of {array.shape[1]} samples, inputs {u.shape[0]} of "
                    f"{u.shape[1]}, allowed are equal numbers; cut them to equal length"
                )
        m, n, n_u = u.shape
        excited = _lines(lines, band, n // n_periods, sample_time)
        inside = np.arange(excited[0], excited[-1] + 1)
        rest = np.setdiff1d(inside, excited)
        blocks = np.arange(m) // n_u if block is None else np.asarray(block, dtype=np.int64)
        return cls(
            inputs=u,
            outputs=y,
            reference=r,
            n_periods=n_periods,
            sample_time=sample_time,
            periodic=periodic,
            excited=excited,
            odd_detection=rest[rest % 2 == 1],
            even_detection=rest[rest % 2 == 0],
            block=blocks,
            input_names=tuple(f"motor_{i + 1}" for i in range(n_u)),
            output_names=tuple(f"motor_{i + 1}" for i in range(y.shape[2])),
            input_units=("Nm",) * n_u,
            coordinate_units=("rad",) * y.shape[2],
            quantity=quantity,
            gears=np.full(y.shape[2], np.nan),
            label=label,
        )

    @property
    def period(self) -> int:
        """Samples of a period or record."""
        return int(self.inputs.shape[1] // self.n_periods)

    @property
    def frequency(self) -> FloatArray:
        """Excited frequencies [Hz], shape (F,)."""
        return np.asarray(self.excited / (self.period * self.sample_time), dtype=float)

    @property
    def motor_position(self) -> FloatArray:
        """Mean motor position [rad or m], shape (n_y,); NaN where the outputs are speeds or accelerations."""
        if self.quantity != "position":
            return np.full(self.outputs.shape[2], np.nan)
        return np.asarray(self.outputs.mean(axis=(0, 1)))

    def response(
        self,
        frequency: FloatArray,
        response: ComplexArray,
        input_inverse: ComplexArray,
        degrees_of_freedom: float,
        *,
        noise_error: ComplexArray | None = None,
        total_error: ComplexArray | None = None,
        distortion: Distortion | None = None,
    ) -> FrequencyResponse:
        """Combine an estimate with the data of its experiments; arguments as of `FrequencyResponse`."""
        return FrequencyResponse(
            frequency=frequency,
            response=response,
            noise_error=noise_error,
            total_error=total_error,
            input_inverse=input_inverse,
            degrees_of_freedom=degrees_of_freedom,
            input_names=self.input_names,
            output_names=self.output_names,
            input_units=self.input_units,
            coordinate_units=self.coordinate_units,
            gears=self.gears,
            motor_position=self.motor_position,
            sample_time=self.sample_time,
            n_periods=self.n_periods,
            n_blocks=len(np.unique(self.block)),
            quantity=self.quantity,
            distortion=distortion,
        )


def _stack(array: ArrayLike, name: str) -> FloatArray:
    """Reshape samples to (m, n, width)."""
    samples = np.asarray(array, dtype=float)
    if samples.ndim not in (1, 2, 3):
        raise InputError(f"{name} have {samples.ndim} dimensions, allowed are (n,), (m, n) and (m, n, width)")
    if not np.all(np.isfinite(samples)):
        raise InputError(f"{name} hold values that are not finite; leave out the records that have them")
    if samples.ndim == 1:
        samples = samples[None]
    return samples[:, :, None] if samples.ndim == 2 else samples


def _lines(lines: ArrayLike | None, band: tuple[float, float] | None, period: int, sample_time: float) -> IntArray:
    every = np.arange(1, (period - 1) // 2 + 1) if lines is None else np.unique(np.asarray(lines, dtype=np.int64))
    if band is not None:
        low, high = (frequency * period * sample_time for frequency in band)
        every = every[(every >= low - 1e-9) & (every <= high + 1e-9)]
    if not len(every):
        given = "" if band is None else f" from {band[0]:g} to {band[1]:g} Hz"
        raise InputError(
            f"a period of {period} samples of {sample_time:g} s has no line in the band{given}; record longer or widen "
            "the band"
        )
    return every
