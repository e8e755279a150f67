"""The experiment to run next: the one that separates the remaining explanations best."""
