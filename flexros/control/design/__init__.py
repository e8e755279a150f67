"""Linear control design: plants with delay and sampling, margins, and methods that make controllers."""
