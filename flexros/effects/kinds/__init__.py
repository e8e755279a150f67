"""What effects have in common: one base class for each place where an effect acts."""
