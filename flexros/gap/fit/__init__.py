"""Parameters of one hypothesis, fitted to a log with their covariance."""
