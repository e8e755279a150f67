"""Information of a frequency response: against the formula with the whole covariance, and against an experiment."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.identify.design.information import frf_information


def complex_normal(generator: np.random.Generator, *shape: int) -> np.ndarray:
    return generator.normal(size=shape) + 1j * generator.normal(size=shape)


def test_is_that_of_the_covariance_of_the_vectorised_response() -> None:
    """2 Re sum Psi^H Lambda^-1 Psi with Lambda = kron(conj(U U^H)^-1, C_E), Paper A eq. 5 and 6."""
    generator = np.random.default_rng(1)
    jacobian, spectrum = complex_normal(generator, 4, 3, 2, 5), complex_normal(generator, 4, 2, 6)
    error = generator.uniform(0.5, 2, size=(4, 3))
    found = frf_information(jacobian, spectrum, error)
    for k in range(4):
        inverse = np.linalg.inv(spectrum[k] @ spectrum[k].conj().T)
        covariance = np.kron(inverse.conj(), np.diag(error[k]))
        psi = np.stack([jacobian[k, :, :, p].ravel(order="F") for p in range(5)], axis=1)
        assert found[k] == pytest.approx(2 * (psi.conj().T @ np.linalg.solve(covariance, psi)).real, rel=1e-9)


def test_logarithmic_form_is_the_same() -> None:
    """With errors relative to the response (eq. 8) the matrices of the estimator LLS give the same information."""
    generator = np.random.default_rng(2)
    response, jacobian = complex_normal(generator, 2, 2), complex_normal(generator, 2, 2, 3)
    spectrum, error = complex_normal(generator, 2, 2), np.array([0.5, 2.0])
    covariance = np.kron(np.linalg.inv(spectrum @ spectrum.conj().T).conj(), np.diag(error))
    inverse = np.diag(1 / response.ravel(order="F"))
    relative = inverse @ np.stack([jacobian[:, :, p].ravel(order="F") for p in range(3)], axis=1)
    weight = np.linalg.inv(inverse @ covariance @ inverse.conj().T)
    expected = 2 * (relative.conj().T @ weight @ relative).real
    assert frf_information(jacobian[None], spectrum[None], error[None])[0] == pytest.approx(expected)


def test_predicts_the_spread_of_an_estimate() -> None:
    """A gain and a delay are fitted to noisy responses; their spread over 400 draws is the inverse information."""
    generator = np.random.default_rng(3)
    frequency, gain, delay = np.linspace(1, 20, 30), 2.0, 0.01
    turned = np.exp(-2j * np.pi * frequency * delay)
    jacobian = np.stack([turned, -2j * np.pi * frequency * gain * turned], axis=-1)
    noise = complex_normal(generator, 400, 30) * 0.1 / np.sqrt(2)
    stacked = np.concatenate([jacobian.real, jacobian.imag])
    found = np.linalg.lstsq(stacked, np.concatenate([noise.real, noise.imag], axis=1).T, rcond=None)[0]
    information = frf_information(jacobian[:, None, None, :], np.ones((30, 1, 1)), np.full((30, 1), 0.01)).sum(axis=0)
    whitened = np.linalg.cholesky(information).T @ found
    assert np.cov(whitened) == pytest.approx(np.eye(2), abs=0.2)
