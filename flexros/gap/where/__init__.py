"""Where a gap shows before any effect is assumed: excess of prediction errors over noise, by place, with p-values."""
