"""A log as an even, checked record: one reader for diagnosis and identification."""
