"""A mapping proposed for a bag: its topics, joints, units and signs, and what was assumed."""
