"""Excitation of identification experiments: multisine, chirp and burst, as speed references with exact integrals."""
