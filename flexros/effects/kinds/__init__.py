"""Base classes of effects, one per place in the loop where an effect acts."""
