"""The simulator of the blind check, with laws and numerics of its own."""
