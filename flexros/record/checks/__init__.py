"""What would lead a diagnosis astray: one check per file, found by itself."""
