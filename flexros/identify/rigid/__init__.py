"""Rigid model by linear regression with base parameters and friction (Moberg 2007, eq. 4.11 to 4.13)."""
