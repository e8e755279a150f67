"""Effects in gears and their springs."""
