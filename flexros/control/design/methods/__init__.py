"""Design methods, one per file; `base.py` is their contract."""
