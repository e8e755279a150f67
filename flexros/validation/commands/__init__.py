"""Commands of this room, which the command line finds by entry points."""
