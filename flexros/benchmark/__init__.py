"""Feedback benchmarks: models, disturbances, measures, cost and demands (Moberg 2007, Paper C)."""
