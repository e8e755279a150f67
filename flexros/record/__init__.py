"""A log as an even, checked record: one reader for all that takes samples of motors."""
