"""Draw the pictures of frequency_response.md: python docs/generate/frequency_response_pictures.py [FOLDER]."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from svg_picture import Curve, Panel, picture

from flexros.identify.frf.estimate.estimate_response import frequency_response_of
from flexros.identify.frf.experiments import Experiments
from flexros.identify.frf.settings import FrfSettings
from flexros.identify.frf.two_mass_example import NOISE, TwoMassAxis, chirp

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray

AT_REST, TOO_EARLY = 30_000, 21_000
BAND = (1.5, 48.0)
TRUE, FOUND = "#888888", "#c8541b"
MAGNITUDE = "speed per torque [dB]"
FREQUENCY = "frequency [Hz]"
DECADES = (1, 2, 5, 10, 20, 50)


def decibels(response: ComplexArray) -> FloatArray:
    """Return the magnitude [dB]."""
    return np.asarray(20.0 * np.log10(abs(response)))


def estimated(axis: TwoMassAxis, u: FloatArray, y: FloatArray, **settings: object) -> tuple[FloatArray, FloatArray]:
    """Return frequencies [Hz] and magnitude of the response to speed [dB]."""
    experiments = Experiments.of(u, y, axis.sample_time, band=BAND, periodic=False)
    chosen = FrfSettings.model_validate({"method": "smoothing", "thinned": False, **settings})
    found = frequency_response_of(experiments, chosen).as_quantity("velocity")
    return found.frequency, decibels(found.response[:, 0, 0])


def response_panel(axis: TwoMassAxis, title: str, found: tuple[FloatArray, FloatArray]) -> Panel:
    """Draw an estimate over the true response."""
    frequency = np.geomspace(1, 50, 800)
    curves = [
        Curve(*found, label="estimated", colour=FOUND, width=1.4),
        Curve(frequency, decibels(axis.speed_response(frequency)), label="true", colour="#111", width=0.9),
    ]
    return Panel(title, FREQUENCY, MAGNITUDE, curves, DECADES, (-90, -70, -50, -30, -10, 10))


def signals(axis: TwoMassAxis, u: FloatArray, y: FloatArray) -> str:
    """Draw figure 4.5: motor speed and torque without and with noise."""
    t = np.arange(AT_REST, dtype=float) * axis.sample_time
    speed = np.diff(y, axis=0, prepend=y[:1]) / axis.sample_time
    seconds = (0, 10, 20, 30)
    rows = []
    for samples, label, ticks in (
        (speed, "motor speed [rad/s]", (-0.2, -0.1, 0, 0.1, 0.2)),
        (u, "torque [Nm]", (-16, -8, 0, 8, 16)),
    ):
        titles = ("without noise", "with noise")
        rows.append(
            [
                Panel(title, "time [s]", label, [Curve(t, samples[:, j], width=0.6)], seconds, ticks, False)
                for j, title in enumerate(titles)
            ]
        )
    return picture(rows)


def hold(axis: TwoMassAxis) -> str:
    """Draw figure 4.9: continuous-time and sampled model up to the Nyquist frequency."""
    frequency = np.geomspace(1, 499, 1500)
    curves = [
        Curve(frequency, decibels(axis.speed_response(frequency)), label="continuous", colour="#1f5fa8"),
        Curve(frequency, decibels(axis.sampled_speed_response(frequency)), "zero-order hold", FOUND, 1.4, "5 3"),
    ]
    ticks = (1, 5, 20, 100, 500)
    return picture(
        [[Panel("continuous and sampled model", FREQUENCY, MAGNITUDE, curves, ticks, (-110, -90, -70, -50, -30))]]
    )


def pictures() -> dict[str, str]:
    """Draw all pictures.

    Returns:
        SVG text by file name.
    """
    axis = TwoMassAxis.builtin()
    rng = np.random.default_rng(1)
    noise = NOISE * rng.standard_normal((AT_REST, 1))
    u, y = axis.closed_loop(chirp(AT_REST, axis.sample_time), np.hstack([np.zeros_like(noise), noise]))
    alone_u, alone_y = axis.closed_loop(np.zeros(AT_REST), noise)
    raw = estimated(axis, u[:, 1], y[:, 1], smoothing=1)
    smooth = estimated(axis, u[:, 1], y[:, 1], smoothing=5)
    early = u[:TOO_EARLY, 1], y[:TOO_EARLY, 1]
    silent = u[:TOO_EARLY, 0], y[:TOO_EARLY, 0]
    panel = response_panel
    return {
        "frf_signals.svg": signals(axis, u, y),
        "frf_smoothing.svg": picture([[panel(axis, "ratio", raw), panel(axis, "triangular window of 5", smooth)]]),
        "frf_leakage.svg": picture(
            [
                [
                    panel(axis, "stopped at 21 s", estimated(axis, *early)),
                    panel(axis, "the same without noise", estimated(axis, *silent)),
                    panel(axis, "without noise, local polynomials", polynomial(axis, *silent)),
                ]
            ]
        ),
        "frf_noise_only.svg": picture(
            [[panel(axis, "noise alone", estimated(axis, alone_u[:, 0], alone_y[:, 0], window="bartlett"))]]
        ),
        "frf_hold.svg": hold(axis),
    }


def polynomial(axis: TwoMassAxis, u: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return frequencies [Hz] and magnitude [dB] by the local polynomial method."""
    return estimated(axis, u, y, method="local_polynomial")


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "explanation"
    for name, text in pictures().items():
        (folder / name).write_text(text, encoding="utf-8")
