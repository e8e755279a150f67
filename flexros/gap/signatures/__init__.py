"""Evidence for and against effects as curves: one kind of picture per file, found by discovery."""
