"""Effects that no fit looks for."""

UNFITTED = {
    "base_tilt": {"x": 0.02, "y": 0.02},
    "body_difference": {"mass": 0.5, "x": 0.01, "zz": 0.01},
    "encoder_quantization": {"step": 2e-4},
    "rotor_inertia": {"added": 0.5},
    "tool_load": {"mass": 2.0, "x": 0.1},
}
"""Parameters of effects that no fit looks for, which therefore have no ranges."""
