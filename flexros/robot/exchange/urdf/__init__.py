"""URDF, and SDF, which is made from it: read, written, and repaired in place."""
