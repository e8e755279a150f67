"""One file per view of the prediction errors."""
