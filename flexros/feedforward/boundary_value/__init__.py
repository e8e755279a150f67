"""Inverse dynamics as a boundary value problem: difference equations, bounded ends, Newton's iteration."""
