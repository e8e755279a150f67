"""Kinematic and elastostatic identification from measured tool positions (Moberg 2007, section 4.2.1)."""
