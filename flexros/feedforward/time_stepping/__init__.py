"""Time stepping of the DAE of the feedforward: equations, initial values, interpreted and compiled steps."""
