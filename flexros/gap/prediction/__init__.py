"""The model tied to a log: predictors and what they predict."""
