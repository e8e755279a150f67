"""Design of identification experiments: in which positions, and how often (Moberg 2007, Paper A, section 5.2)."""
