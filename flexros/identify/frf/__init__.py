"""Frequency response functions: from samples of torques and positions to responses with their covariance."""
