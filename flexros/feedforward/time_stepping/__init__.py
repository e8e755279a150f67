"""The DAE of the feedforward, stepped through time: equations, start, interpreted and compiled steps."""
