"""Feedforward: motor references and torques from a desired motion of the tool (Moberg 2007, chapter 5 and Paper B)."""
