"""Long computations whose results are committed: one file per campaign, found by its name, each resumable."""
