"""What to run next: the experiment that separates the remaining explanations best."""
