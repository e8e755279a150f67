"""What a blind case consists of: deviations, sizes, references, controllers, conditions."""
