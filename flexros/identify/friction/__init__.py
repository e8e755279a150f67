"""Friction of one motor at constant speeds, and laws fitted to it (Moberg 2007, section 3.2.3, figure 3.8)."""
