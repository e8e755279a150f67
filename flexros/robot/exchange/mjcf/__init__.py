"""MJCF of MuJoCo: one arm read from it, written, and repaired in place."""
