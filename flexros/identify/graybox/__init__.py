"""Gray-box identification: a linearised robot fitted to frequency responses (Moberg 2007, Paper A)."""
