"""Numbers that a robot file leaves out: a diagnosis estimates them, since unknown is not wrong."""
