"""Proof of our own claims: blind check, campaigns and benchmarks. Nothing imports this room."""
