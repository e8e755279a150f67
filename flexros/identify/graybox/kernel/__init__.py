"""Machine code of the frequency model: responses, Jacobian and normal equations."""
