"""Diagnosis of the gap between a robot and its model: where, which effect, how far, what next, repair."""
