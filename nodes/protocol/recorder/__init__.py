"""Recording: which messages a log keeps, and how far the loop may run ahead of it."""
