"""Identification: excitation, frequency responses, gray-box fit, experiment positions."""
