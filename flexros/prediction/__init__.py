"""What all predictors of a log share: observer design and damped least squares."""
