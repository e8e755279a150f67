"""Common parts of all predictors of a log: observer design and damped least squares."""
