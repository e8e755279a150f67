"""Rate of a measured signal by differences and a low-pass filter."""

from __future__ import annotations

import casadi


class FilteredRate:
    """Filtered backward differences v_k = (tau v_(k-1) + y_k - y_(k-1)) / (tau + T), zero at the first sample.

    The state is [y_(k-1), v_(k-1), started], 2 n + 1 numbers for n signals.

    Args:
        state: State, SX (2 n + 1, 1).
        signal: Measured values, SX (n, 1).
        filter_time: Time constant tau of the low-pass filter [s], SX (n, 1) or a number.
        sample_time: Time between two samples [s].

    Attributes:
        rate: The rate [1/s], SX (n, 1).
        after: Next state.
    """

    def __init__(self, state: casadi.SX, signal: casadi.SX, filter_time: casadi.SX | float, sample_time: float) -> None:
        n = signal.numel()
        before = casadi.if_else(state[-1] > 0.5, state[:n], signal)
        self.rate = (filter_time * state[n : 2 * n] + (signal - before)) / (filter_time + sample_time)
        self.after = casadi.vertcat(signal, self.rate, 1.0)

    @staticmethod
    def size(n: int) -> int:
        """Return the number of states for n signals."""
        return 2 * n + 1
