"""Events of the operating system: signals and steps of the system clock."""
