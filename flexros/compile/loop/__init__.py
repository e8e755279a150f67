"""The closed loop in machine code: controller, plant, delays and noise over all samples."""
