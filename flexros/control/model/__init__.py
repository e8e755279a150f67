"""Models inside control laws: the rigid arm and the simplified flexible-joint robot, as symbolic graphs."""
