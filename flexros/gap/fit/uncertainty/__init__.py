"""How well sizes are known: errors of colour, of form and of timing, and what parts of a log and two logs differ by."""
