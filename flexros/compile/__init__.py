"""Symbolic graph to machine code, with the CasADi virtual machine as fallback and cross-check."""
