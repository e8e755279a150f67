"""What the torques of a log show at once, before any search for causes: friction, rotors, loads, timing."""
