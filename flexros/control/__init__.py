"""Feedback controllers: one control law per file, and the runner that steps one sample by sample."""
