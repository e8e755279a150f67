"""The multivariable benchmark: robots of several axes with moving references, by the rules of Paper C."""
