"""Estimators: from spectra of experiments to responses with their covariance."""
