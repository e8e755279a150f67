"""Topics, node parameters and scenarios as typed, validated objects."""
