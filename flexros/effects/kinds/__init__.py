"""Base classes of effects, one per point of the loop at which an effect acts."""
